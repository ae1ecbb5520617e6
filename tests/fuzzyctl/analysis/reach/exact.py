"""Exact values of affine forms at values of their symbols, whether a form holds a number; expressions from text."""

import ast
from fractions import Fraction

import flint
import numpy as np

from fuzzyctl.analysis.reach.forms import as_form
from fuzzyctl.expr import Binary, Call, Compare, Logic, Name, Negate, Number, Where

PRECISION = 300


def arb(x):
    """Return a rational number to many digits."""
    flint.ctx.prec = PRECISION
    x = Fraction(x)
    return flint.arb(flint.fmpq(x.numerator, x.denominator))


def at(form, symbols, own=0, box=0):
    """Return the value of a form where its symbols, and its own error, have some values."""
    row = form[min(box, form.shape[0] - 1)]
    products = (Fraction(float(g)) * Fraction(e) for g, e in zip(row[2:], symbols, strict=False))
    return Fraction(float(row[0])) + Fraction(float(row[1])) * Fraction(own) + sum(products, Fraction(0))


def holds(value, symbols, number, box=0):
    """Return whether a number is among the values of a form at some values of its symbols.

    A number that is known to many digits is taken to be among them if this is not refuted.
    """
    form = as_form(value)
    if np.isnan(form).any():
        return True  # any number
    row = form[min(box, form.shape[0] - 1)]
    if np.isinf(row).any():
        return True
    middle = at(form, symbols, 0, box)
    if isinstance(number, flint.arb):
        return not (abs(number - arb(middle)) > arb(Fraction(float(row[1]))))
    return abs(Fraction(number) - middle) <= Fraction(float(row[1]))


OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "^"}
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}


def expression(text):
    """Return an expression that is written as one of Python; `where(c, a, b)` is a if c else b."""
    return _expression(ast.parse(text, mode="eval").body)


def _expression(node):
    match node:
        case ast.Constant(value=value):
            return Number(float(value))
        case ast.Name(id=name):
            return Name(name)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return Negate(_expression(operand))
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return Logic("not", (_expression(operand),))
        case ast.BinOp(left=left, op=op, right=right):
            return Binary(OPERATORS[type(op)], _expression(left), _expression(right))
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            return Compare(COMPARISONS[type(op)], _expression(left), _expression(right))
        case ast.BoolOp(op=op, values=values):
            return Logic("and" if isinstance(op, ast.And) else "or", tuple(map(_expression, values)))
        case ast.Call(func=ast.Name(id="where"), args=arguments):
            return Where(*map(_expression, arguments))
        case ast.Call(func=ast.Name(id=function), args=arguments):
            return Call(function, tuple(map(_expression, arguments)))
    raise TypeError(ast.dump(node))
