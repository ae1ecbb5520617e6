"""Texts of tests of the editor: a system, and a loop with a system, a controller and a plant."""

SYSTEM = """\
system tip "Tip for a meal"
defuzzifier center_average
param most = 20
hedge hardly(d) = d ^ 3

input service in [0, 10]
  poor = ramp(10, 0)
  good = ramp(0, 10)
input food "Food" in [0, 10]
  terms bad fine great
output tip in [0, most] else 0
  terms small=0 large=most

table tip = service x food
         bad    fine   great
  poor | small  small  large
  good | small  large  large

require tip >= 0
"""

LOOP = """\
system surface
defuzzifier center_average
input e in [-1, 1]
  terms N Z P
output u in [-1, 1]
  terms N Z P
table u = e
    N  Z  P
  | N  Z  P

controller law
input r
input y
param gain in [0, 9] = 2
state level = 0
let error = r - y
next level = level + error
output u = gain * surface(e = error) + level
every 10 ms

plant lag
input u
param T = 1
state x = 0
der x = (u - x) / T
output y = x

loop closed
block law = law(r, lag.y)
block lag = lag(u = law.u)
let r = steps(0: 1)
measure iae = iae(lag.y, r)
run 5 s
"""
