"""Loops whose sets are compared with runs of their members."""

from fuzzyctl import loads

TANK = """
controller law
input r
input y
param k in [0, 10] = 2
state s in [-1, 1] = 0
let e = r - y
next s = clamp(s + 0.1 * e, -1, 1)
output v = clamp(k * e + s, -0.5, 1)
every 100 ms
plant tank
param A in (0, 50] = 4
input v
state h = 0.3
der h = (v - 0.4 * sqrt(2 * h)) / A
output y = h
loop l
param goal in [0, 1] = 0.5
block law = law(r=goal, y=tank.y)
block tank = tank(law.v)
for tank.h in [0.25, 0.4]
for tank.A in [3, 5]
for law.k in [1, 2]
run 6 s
"""

#: A fast and a slow controller; the slow one keeps its output in between.
RATES = """
controller outer
input y
state n = 0
next n = n + 1
output r = clamp(1 - y + 0.01 * n, -2, 2)
every 300 ms
controller inner
input r
input w
output u = 3 * r - w
every 100 ms
plant mass
input u
state x = 0
state w = 0
der x = w
der w = u - 0.2 * abs(w) * w
output y = x
output speed = w
loop l
block outer = outer(mass.y)
block inner = inner(outer.r, mass.speed)
block mass = mass(inner.u)
for mass.x in [-0.2, 0.2]
run 4 s
"""

#: A relay, references of the time, a jump within a step.
SWITCHED = """
controller law
input r
input y
output u = where(r - y > 0, 1, -1)
every 50 ms
plant heater
input u
state T = 0
der T = u + where(T > 0.3, -0.5, 0.25) - T
output y = T
loop l
let down = ramp(begin=1 s, end=1.3 s, low=0, high=-0.3)
let r = steps(0: 0.2, 0.5 s: 0.6) + 0.1 * pulse(0.72 s, 0.9 s) + down + 0.05 * sin(3 * t)
block law = law(r, heater.y)
block heater = heater(law.u)
for heater.T in [0, 0.125]
run 1.5 s
"""

DISTURBED = """
controller law
input x
input v
output u = -4 * x - 3 * v
every 50 ms
plant mass
input u
input w
state x = 0
state v = 0
der x = v
der v = u + w * cos(x)
output px = x
output pv = v
loop l
disturbance w in [-0.5, 0.3] = 0
block law = law(mass.px, mass.pv)
block mass = mass(law.u, w)
for mass.x in [-0.1, 0.1]
for mass.v in [-0.1, 0.1]
run 3 s
"""

FUZZY = """
system surface
and product
defuzzifier center_average
input e in [-1, 1]
  terms N Z P
input de in [-1, 1]
  terms N Z P
output u in [-1, 1]
  terms N Z P
table u = e x de
       N  Z  P
  N |  N  N  P
  Z |  N  Z  P
  P |  N  P  P
controller law
input x
input v
output u = -2 * surface(x, v)
every 100 ms
plant pendulum
input u
state th = 0.2
state w = 0
der th = w
der w = 0.5 * sin(th) + u
output x = th
output v = w
loop l
block law = law(pendulum.x, pendulum.v)
block pendulum = pendulum(law.u)
for pendulum.th in [0.3, 0.7]
for pendulum.w in [-0.4, 0.2]
run 5 s
"""

LOOPS = {"tank": TANK, "rates": RATES, "switched": SWITCHED, "disturbed": DISTURBED, "fuzzy": FUZZY}


def loop_of(text, *lines):
    """Return a loop with further lines."""
    return loads(text + "".join(f"{line}\n" for line in lines), block="l")
