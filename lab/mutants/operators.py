"""The mutants of a module: one operator, condition, number or statement is another one in each."""

import ast
import random
from collections.abc import Iterator
from typing import NamedTuple

SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
NAMES = {"max": "min", "min": "max", "any": "all", "all": "any"}


class Mutant(NamedTuple):
    """One change in a function: `was` became `is_now`; `tree` is the changed module."""

    function: str
    was: str
    is_now: str
    tree: ast.Module

    def __str__(self) -> str:
        return f"{self.function}: {_one_line(self.was)} -> {_one_line(self.is_now)}"


def mutants_of(source: str, count: int) -> list[Mutant]:
    """`count` mutants of a module, the same ones at every call, or all where there are fewer."""
    total = sum(1 for _ in _changeable(ast.parse(source)))
    rng = random.Random(source)  # noqa: S311  # a choice that repeats
    return [_mutant(source, number) for number in sorted(rng.sample(range(total), min(count, total)))]


def _mutant(source: str, number: int) -> Mutant:
    tree = ast.parse(source)
    function, parent, field, index, node, instead = next(
        each for k, each in enumerate(_changeable(tree)) if k == number
    )
    was = ast.unparse(node)
    if index is None:
        setattr(parent, field, instead)
    else:
        getattr(parent, field)[index] = instead
    ast.copy_location(instead, node)
    ast.fix_missing_locations(tree)
    return Mutant(function, was, ast.unparse(instead), tree)


Place = tuple[str, ast.AST, str, int | None, ast.expr | ast.stmt, ast.expr | ast.stmt]


def _changeable(tree: ast.Module) -> Iterator[Place]:
    """Every place in a function, with what could be there instead."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            for statement in function.body:
                yield from _inside(function.name, statement)
            yield from _places(function.name, function, "body")


def _inside(function: str, node: ast.AST) -> Iterator[Place]:
    if isinstance(node, ast.FunctionDef):
        return
    for field, _ in ast.iter_fields(node):
        yield from _places(function, node, field)
    for child in ast.iter_child_nodes(node):
        yield from _inside(function, child)


def _places(function: str, parent: ast.AST, field: str) -> Iterator[Place]:
    value = getattr(parent, field)
    for index, node in enumerate(value) if isinstance(value, list) else ((None, value),):
        if isinstance(node, ast.expr | ast.stmt):
            for instead in _instead(node):
                yield function, parent, field, index, node, instead


def _instead(node: ast.expr | ast.stmt) -> Iterator[ast.expr | ast.stmt]:
    match node:
        case ast.Compare(ops=[operator]) if type(operator) in SWAPS:
            yield ast.Compare(node.left, [SWAPS[type(operator)]()], node.comparators)  # type: ignore[list-item]
        case ast.BoolOp():
            yield ast.BoolOp(SWAPS[type(node.op)](), node.values)  # type: ignore[arg-type]
        case ast.BinOp() if type(node.op) in SWAPS:
            yield ast.BinOp(node.left, SWAPS[type(node.op)](), node.right)  # type: ignore[arg-type]
        case ast.UnaryOp(op=ast.Not()):
            yield node.operand
        case ast.Call(func=ast.Name(id=name)) if name in NAMES:
            yield ast.Call(ast.Name(NAMES[name], ast.Load()), node.args, node.keywords)
        case ast.Constant(value=bool() as flag):
            yield ast.Constant(not flag)
        case ast.Constant(value=int() | float() as number):
            yield ast.Constant(number + 1)
        case ast.If():
            yield ast.If(ast.Constant(value=False), node.body, node.orelse)
        case ast.IfExp():
            yield node.orelse
        case ast.Assign(targets=[ast.Attribute()]) | ast.AugAssign() | ast.Expr(value=ast.Call()):
            yield ast.Pass()


def _one_line(text: str) -> str:
    return text.splitlines()[0]
