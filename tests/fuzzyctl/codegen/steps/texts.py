"""Controllers of all kinds, each small."""

SURFACE = """system surface
and product
defuzzifier center_average
input e in [-2, 2]
  terms N Z P
input d in [-2, 2]
  terms N Z P
output u in [-1, 1]
  terms N@-1 Z@0 P@1
table u = e x d
     N Z P
  N | N N Z
  Z | N Z P
  P | Z P P
"""
#: Where x lies between its terms no rule fires.
GAPS = """system {name}
defuzzifier weighted_average
input x in [-2, 2]
  low  = triangle(-inf, -2, -0.5)
  high = triangle(0.5, 2, inf)
output u in [0, 1] else {otherwise}
  a = constant(0)
  b = constant(1)
if x is low then u is a
if x is high then u is b
"""
CURVED = """system curved
input e in [-2, 2]
  near = gaussian(0, 0.5)
  far  = bell(1, 2, 2)
output u in [-1, 1]
  a = triangle(-1, -0.5, 0)
  b = triangle(0, 0.5, 1)
if e is near then u is a
if e is far then u is b
"""
ADAPTIVE = """system gain
defuzzifier weighted_average
param gamma = 4
input s in [-2, 2]
  terms N Z P
input e in [-2, 2]
output F in [-0.5, 0.5] adaptive rate gamma * s / (e + 3)
  terms N=-0.1 Z=0 P=0.1
table F = s
     N Z P
   | N Z P
"""
HOLDING = """system pump
defuzzifier weighted_average
input level in [-2, 2]
  low  = triangle(-inf, -2, -0.5)
  high = triangle(0.5, 2, inf)
output on in [0, 1] else hold(0)
  terms no=0 yes=1
output speed in [0, 5] else hold
  terms slow=1 fast=4
if level is low then on is yes, speed is fast
if level is high then on is no, speed is slow
"""
PID = """controller {name} "Fuzzy PID controller"
source "a book: Eq. (1)"
input r in [-2, 2] unit "m"
input y "level" in [-2, 2] unit "m"
param GE in (0, 10] = 0.7
let e = r - y
let d = derivative(e, filter=0.3 s)
let w = integral(surface(GE * e, 0.1 * d), hold=w > 2 or w < -2)
output u "valve" in [-3, 3] unit "V" = clamp(w + 0.5 * e, -3, 3)
"""

TEXTS = {
    "pid": SURFACE + PID.format(name="pid") + "every 50 ms\n",
    "timed": SURFACE + PID.format(name="timed"),
    "operators": SURFACE
    + "controller operators\ninput x in [-2, 2]\ninput y in [-2, 2]\noutput a = previous(x, start=0.25)\n"
    "output b = difference(x * y)\noutput c = derivative(y)\noutput d = lowpass(surface(x, y), 0.3)\n"
    "output f = rate_limit(x, 2) + hysteresis(y, -0.2, 0.2)\noutput g = delay(x - y, 7, start=-0.5)\n",
    "pure": SURFACE + "controller pure\ninput x in [-2, 2]\noutput y = surface(x, 0.5) ^ 2\nevery 1 s\n",
    "clock": "controller clock\nstate phase = 0\nnext phase = where(phase >= 0.9, 0, phase + 0.1)\n"
    "output tick = phase\nevery 10 ms\n",
    "waits": "controller waits\ninput x in [-2, 2]\noutput y = delay(x, 30) + delay(x / 2, 3)\nevery 10 ms\n",
    "chains": "controller chains\ninput x in [-2, 2]\nstate a = 0\nstate b = 0\nstate d = 0\nstate f = 0\n"
    "state g = 1\nstate h = 1\nnext a = x\nnext b = a\nnext d = b\nnext f = d\nnext g = f\nnext h = g\n"
    "output y = f + h\noutput z = g + a\noutput w = delay(delay(x, 3), 2)\nevery 1 s\n",
    "inner": "controller inner\ninput x\nparam k = 1\nstate s in [0, inf) = k\nnext s = 0.9 * s + 0.1 * abs(x)\n"
    "output y = k * s\ncontroller outer\ninput x in [-2, 2]\nblock a = inner(x)\nblock b = inner(a.y, k=2)\n"
    "output z = a.y + b.y\nevery 0.1 s\n",
    "refusing": GAPS.format(name="gaps", otherwise="error")
    + "controller refusing\ninput x in [-2, 2]\noutput y = lowpass(gaps(x), 0.2)\nevery 0.05 s\n",
    "silent": GAPS.format(name="gaps", otherwise="nan")
    + "controller silent\ninput x in [-2, 2]\nlet g = gaps(x)\nstate n = 0\nnext n = clamp(n + g, 0, 3)\n"
    "output y = g\noutput z = max(g, n)\nevery 0.05 s\n",
    "partial": "controller partial\ninput x in [-2, 2]\ninput y in [-2, 2]\nlet q = sqrt(x) / y\n"
    "state s = 1\nnext s = where(abs(q) < 10, 0.5 * s + q, 1)\noutput z = q + s\n"
    "output w = delay(sqrt(y), 6)\nevery 1 ms\n",
    "curved": CURVED
    + "controller smooth\ninput x in [-2, 2]\noutput y = curved(x) + sin(x) + exp(-x * x)\nevery 1 ms\n",
    "adaptive": ADAPTIVE + "controller adaptive\ninput x in [-2, 2]\ninput y in [-2, 2]\noutput f = gain(x, y)\n",
    "holding": HOLDING + "controller holding\ninput x in [-2, 2]\nlet p = pump(x)\noutput a = p.on\n"
    "output b = max(p.speed, 1.5) + p.speed\nevery 10 ms\n",
    "greek": "controller ρύθμιση\ninput σ in [-2, 2]\nstate double = 0\nnext double = 0.5 * double + σ\n"
    "output Σ = double\nevery 1 ms\n",
}
