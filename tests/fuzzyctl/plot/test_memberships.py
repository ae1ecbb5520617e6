import numpy as np
from matplotlib.figure import Figure

from fuzzyctl.loading.load import load, loads
from fuzzyctl.plot.memberships import draw_terms, draw_variable
from fuzzyctl.support.shipped import rules_folder


class TestDrawVariable:
    def test_each_term_is_a_line_that_reaches_its_peak(self, base):
        system = loads(base)
        ax = draw_variable(Figure().subplots(), system, system.input("x"))
        assert [np.max(line.get_ydata()) for line in ax.get_lines()] == [1, 1, 1]
        assert [t.get_text() for t in ax.texts] == ["N", "Z", "P"]
        assert ax.get_xlim() == (-1, 1)

    def test_the_axis_says_the_unit(self, base):
        system = loads(base)
        assert draw_variable(Figure().subplots(), system, system.input("y")).get_xlabel() == "y [m]"


class TestDrawTerms:
    def test_every_variable_has_its_panel(self):
        figure = Figure()
        draw_terms(figure, load(rules_folder() / "ais_reaction.fz"))
        assert [a.get_xlabel() for a in figure.axes] == ["σ*", "dσ*/dt [1/s]", "f"]
