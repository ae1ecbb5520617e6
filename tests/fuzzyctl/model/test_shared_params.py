import pytest

from fuzzyctl import DiagnosticError, Experiment, Loop, loads, simulate

SYSTEM = "system s\ndefuzzifier weighted_average\ninput e in [-9, 9]\nall = function(1)\noutput y in [-99, 99]\n"
SYSTEM += "if e is all then y is function(k * e)\n"
INNER = "controller inner\ninput e\noutput u = k * e\n"
LOOP = "loop l\nblock c = c(p.y)\nblock p = p(c.u)\nmeasure m = final(p.y)\nrun 1 s step 10 ms\n"
GIVEN = (
    LOOP.replace("c(p.y)", "c(p.y, k=j)").replace("p(c.u)", "p(c.u, k=j)").replace("loop l", "loop l\nparam j = 0.5")
)


def controller(expression):
    return f"controller c\ninput y\nblock i = inner(y)\noutput u = {expression}\n"


def plant(expression="u"):
    return f"plant p\ninput u\nstate x = 1\nder x = {expression}\noutput y = x\n"


#: One place each in which k is read: by the controller, the one inside it, its system, the plant.
USES = {
    "controller": controller("-k * y") + plant(),
    "inner": controller("-i.u") + plant(),
    "system": controller("-s(y)") + plant(),
    "plant": controller("-y") + plant("k * u"),
}


def written(text):
    return loads(text, block=Loop)


@pytest.mark.parametrize("use", USES)
class TestAParamBeforeTheFirstBlock:
    def test_it_is_one_number_for_all_blocks(self, use):
        rest = f"{SYSTEM}{INNER}{USES[use]}{LOOP}"
        expected = simulate(written(f"param k = 0.5\n{rest}"))
        assert simulate(written(f"param k = 2\n{rest}"), k=0.5)["p.y"] == pytest.approx(expected["p.y"], abs=1e-15)
        assert expected["p.y"][-1] == pytest.approx(0.607, abs=0.002)  # exp(-0.5), sampled

    def test_it_may_be_free(self, use):
        loop = written(f"param k = 2\n{SYSTEM}{INNER}{USES[use]}{LOOP}")
        run = Experiment(loop, "python", free=["k"]).run([0.5])
        assert run.measures["m"] == pytest.approx(simulate(loop, k=0.5).measures["m"], abs=1e-15)

    def test_a_value_that_a_block_is_given_holds_for_all_inside(self, use):
        rest = f"{SYSTEM}{INNER}{USES[use]}{GIVEN}"
        loop = written(f"param k = 2\n{rest}")
        expected = simulate(written(f"param k = 0.5\n{SYSTEM}{INNER}{USES[use]}{LOOP}")).measures["m"]
        assert simulate(loop).measures["m"] == pytest.approx(expected, abs=1e-15)
        assert simulate(loop, k=9).measures["m"] == pytest.approx(expected, abs=1e-15)
        assert Experiment(loop, "python", free=["k"]).run([9]).measures["m"] == pytest.approx(expected, abs=1e-15)
        other = Experiment(loop, "python", free=["j", "k"]).run([0.25, 9]).measures["m"]
        assert other == pytest.approx(simulate(loop, j=0.25).measures["m"], abs=1e-15) != expected

    def test_one_that_is_free_in_a_block_holds_for_all_inside(self, use):
        block = "p" if use == "plant" else "c"
        loop = written(f"param k = 2\n{SYSTEM}{INNER}{USES[use]}{LOOP}")
        expected = simulate(written(f"param k = 0.5\n{SYSTEM}{INNER}{USES[use]}{LOOP}")).measures["m"]
        assert Experiment(loop, "python", free=[f"{block}.k"]).run([0.5]).measures["m"] == pytest.approx(expected)
        assert simulate(loop, **{f"{block}.k": 0.5}).measures["m"] == pytest.approx(expected)


def test_its_range_may_be_open_at_an_end():
    loop = written(f"param k in (0, 9] = 2\n{INNER}{USES['plant']}{LOOP}")
    with pytest.raises(DiagnosticError, match=r"param 'c\.k' is 0, outside of \(0, 9\]"):
        simulate(loop, **{"c.k": 0})


def test_a_block_that_is_given_a_value_keeps_it():
    loop = written(f"param k = 2\n{INNER}{USES['controller']}{LOOP.replace('c(p.y)', 'c(p.y, k=0.5)')}")
    assert simulate(loop, k=9).measures == simulate(loop).measures


def test_a_controller_passes_it_to_its_systems():
    loop = written(f"param k = 2\n{SYSTEM}{INNER}{USES['system']}{LOOP}")
    (law,) = (c for c in loop.controllers if c.name == "c")
    assert law.with_params(k=0.5).systems[0](e=1) == 0.5
