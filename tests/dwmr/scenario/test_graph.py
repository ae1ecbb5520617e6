"""Graphs of formations: ways to the reference, and mistakes in places, weights and references of robots."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dwmr import read
from dwmr.cli.main import main
from fuzzyctl import DiagnosticError
from tests.dwmr.scenarios import PAPER, messages, mistakes, run, warned
from tests.sizes import examples

LINE = '{kind="line",start_x=0,start_y=0,angle=0,speed=0.5}'


def neighbours(*parts):
    """A consensus of some neighbours: name, or name and weight."""
    texts = [
        f'{{leader="{name}",separation=1.25,bearing=2.0{"".join(f",weight={one}" for one in weight)}}}'
        for name, *weight in parts
    ]
    return f'{{kind="consensus",neighbours=[{",".join(texts)}]}}'


#: By value of robots.follower1.formation the message, as it begins.
REFUSED = {
    neighbours(("leader", 0.5), ("follower2", 0.4)):
        "robots.follower1.formation: the weights sum to 0.9, expected 1",
    neighbours(("leader", 1.5), ("follower2", -0.5)): "robots.follower1.formation.neighbours.0.weight must be <= 1",
    neighbours(("leader", 0.5), ("follower2",)):
        "robots.follower1.formation: give a weight to each neighbour, or to none",
    neighbours(): "robots.follower1.formation.neighbours must have at least 1 element, has none",
    neighbours(("leader",), ("follower3",)):
        "robots.follower1.formation.neighbours.1.leader names an unknown robot 'follower3'",
    neighbours(("leader",), ("follower1",)):
        "robots.follower1.formation.neighbours.1.leader = 'follower1': a robot cannot follow itself",
    '{kind="consensus"}': "robots.follower1.formation.neighbours is missing",
    '{kind="star",leader="leader"}':
        "robots.follower1.formation.kind must be one of 'separation-bearing', 'virtual-structure', 'consensus'",
    '{kind="virtual-structure",separation=-1,bearing=0}': "robots.follower1.formation.separation must be >= 0 m",
    '{kind="virtual-structure",leader="leader",separation=1,bearing=0}':
        "unknown key robots.follower1.formation.leader",
    '{separation=1,bearing=0}': "robots.follower1.formation.leader is missing",
}  # fmt: skip


@pytest.mark.parametrize("value", REFUSED)
def test_places_that_cannot_be_are_refused(value):
    assert messages("paper", f"robots.follower1.formation={value}")[0].startswith(REFUSED[value])


def test_robots_that_only_follow_one_another_are_refused_once():
    (one,) = messages(
        "paper",
        f"robots.follower1.formation={neighbours(('follower2',))}",
        f"robots.follower2.formation={neighbours(('follower1',))}",
    )
    assert one == (
        "robots.follower1.formation.neighbours.0.leader leads back to follower1: follower1 -> follower2 -> follower1; "
        "some robot must follow the reference"
    )


def test_a_circle_is_shown_in_the_scenario_itself_not_in_one_that_it_extends(tmp_path):
    file, place = tmp_path / "circle.toml", "separation = 1.25, bearing = 3.0"
    start = "x_0 = -9.0\ny_0 = 9.0\ntheta_0 = 0.0\nd = 0.4\n"
    file.write_text(
        f'extends = "paper"\n[robots.back]\n{start}formation = {{ leader = "follower2", {place} }}\n'
        f'[robots.follower2]\nformation = {{ leader = "back", {place} }}\n'
    )
    with pytest.raises(DiagnosticError) as caught:
        read(file)
    (one,) = caught.value.diagnostics
    assert one.span.source.name == str(file)
    assert "follower2 -> back -> follower2" in one.message


def test_weights_with_few_decimals_count_as_shares():
    """A place 1e6 m away would move by metres."""
    weights = (0.333333, 0.333333, 0.333333)
    value = neighbours(*zip(("leader", "follower2", "leader"), weights, strict=True))
    edges = read("paper", [f"robots.follower1.formation={value}"]).scenario.robots["follower1"].edges
    assert sum(one.weight for one in edges) == pytest.approx(1.0, abs=1e-15)


def test_a_long_circle_is_shown_in_part():
    robot = 'robots.r{}={{x_0=0,y_0={},theta_0=0,d=0.4,formation={{leader="r{}",separation=1.25,bearing=2.0}}}}'
    robots = [robot.format(k, 2 * k, (k + 1) % 40) for k in range(40)]
    first = next(m for m in messages("paper", *robots) if "leads back" in m)
    assert first.count("->") == 11
    assert "-> ... -> r0; some robot" in first


def test_a_cycle_from_which_a_way_leads_to_the_reference_is_none():
    overrides = (
        f"robots.follower1.formation={neighbours(('follower2',), ('leader',))}",
        f"robots.follower2.formation={neighbours(('follower1',), ('leader',))}",
    )
    assert warned("paper", *overrides) == []


class TestOwnReference:
    def test_of_a_follower_is_refused(self):
        (one,) = mistakes("paper", f"robots.follower1.reference={LINE}")
        assert one.message == (
            "robots.follower1.reference of kind 'line', but follower1 follows leader: only a robot on the reference "
            "has its own"
        )

    @pytest.mark.parametrize(
        ("value", "message"),
        [
            ('{kind="line"}', "robots.leader.reference.start_x is missing"),
            ('{kind="oval"}', "robots.leader.reference.kind must be one of 'eight', 'circle'"),
            (LINE.replace("0.5", "1e-9"), "the reference stands still"),
            ('{kind="csv",file="nowhere.csv"}', "robots.leader.reference.file = 'nowhere.csv' names a file that does"),
            ('{kind="waypoints",points=[[0,0],[0,0]],speed=1}',
             "robots.leader.reference.points.1 is the same place as robots.leader.reference.points.0"),
        ],
    )  # fmt: skip
    def test_that_is_wrong_is_named_with_its_key(self, value, message):
        assert messages("paper", f"robots.leader.reference={value}")[0].startswith(message)

    def test_faster_than_the_robot_is_warned_of(self):
        (one,) = warned("paper-with-limits", f"robots.leader.reference={LINE.replace('0.5', '3')}")
        assert one.startswith("robots.leader.actuator.v_limit = 2 m/s is below the 3 m/s that the path asks for")

    def test_equal_to_that_of_the_scenario_changes_nothing_and_another_one_is_followed(self):
        eight = '{kind="eight",amplitude_x=15.0,amplitude_y=15.0,period=200.0}'
        usual, equal, line = (
            run("paper", "fcafsmc", "run.horizon=2", *one)
            for one in ((), (f"robots.leader.reference={eight}",), (f"robots.leader.reference={LINE}",))
        )
        assert (equal.values == usual.values).all()
        assert line["x_r"][:, 0] == pytest.approx(0.5 * line.t)
        assert line["y_r"][:, 0] == pytest.approx(0.0)
        assert (line["y_r"][:, 1] != usual["y_r"][:, 1]).any()


def chain(count, base="paper"):
    """The text of a scenario whose robots follow one another."""
    lines = [f'extends = "{base}"', 'name = "chain"', "obstacles = []", "disturbances = []"]
    before = "follower1"
    for k in range(count):
        place = f'formation = {{ leader = "{before}", separation = 1.25, bearing = 3.141592653589793 }}'
        lines += [f"[robots.r{k}]", f"x_0 = {-5.0 - 1.3 * k}", "y_0 = 3.0", "theta_0 = 0.0", "d = 0.4", place]
        before = f"r{k}"
    return "\n".join(lines)


@pytest.mark.parametrize(("base", "count"), [("paper", 200), ("ackermann", 40)])
def test_a_chain_may_be_long(tmp_path, capsys, base, count):
    path = tmp_path / "chain.toml"
    path.write_text(chain(count, base), encoding="utf-8")
    assert len(read(path).scenario.robots) == count + 3
    main(["show", str(path)], standalone_mode=False)
    (last,) = [line for line in capsys.readouterr().out.splitlines() if line.lstrip().startswith(f"r{count - 1} ")]
    assert len(last) - len(last.lstrip()) == 2 * (count + 2)  # one step for each robot before it


ROBOTS = ("leader", "follower1", "follower2", "r0", "r1")


@settings(max_examples=examples(25))
@given(st.lists(st.lists(st.sampled_from(ROBOTS), min_size=1, max_size=2), min_size=4, max_size=4))
def test_robots_without_a_way_to_the_reference_are_refused_and_no_others(leaders):
    followed = dict(zip(ROBOTS[1:], leaders, strict=True))
    followed = {name: [one for one in each if one != name] or ["leader"] for name, each in followed.items()}
    reached = {"leader"}
    for _ in followed:
        reached |= {name for name, each in followed.items() if reached & set(each)}
    overrides = [f"robots.{name}.{key}={k}" for k, name in enumerate(ROBOTS[3:]) for key in ("x_0", "y_0", "theta_0")]
    overrides += [f"robots.{name}.d=0.4" for name in ROBOTS[3:]]
    for name, each in followed.items():
        overrides.append(f"robots.{name}.formation={neighbours(*((one,) for one in each))}")
    try:
        read(PAPER, overrides)
    except DiagnosticError as error:
        assert reached != set(ROBOTS)
        named = {one.message.split(".")[1] for one in error.diagnostics}
        assert named
        assert named.isdisjoint(reached)
    else:
        assert reached == set(ROBOTS)
