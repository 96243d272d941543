"""A plan with the products of its query beside it becomes one result per product."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

LABELS = {"standard": "Shortest", "long": "Safest", "heavy": "Least energy"}
World = TypeVar("World")


def expand(results: Sequence[Mapping[str, Any]], worlds: Sequence[World]) -> tuple[list[Mapping[str, Any]], list[World]]:
    """Results and their worlds with every plan that has ``products`` replaced by these; ``asked`` marks the one the plan was made for."""
    shown: list[tuple[Mapping[str, Any], World]] = []
    for result, world in zip(results, worlds, strict=True):
        shown.extend((each, world) for each in products_of(result))
    return [result for result, _ in shown], [world for _, world in shown]


def products_of(result: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """One result per product that was found; the result itself where it has none."""
    products = result.get("products")
    if not isinstance(products, Mapping):
        return [result]
    query = result.get("query")
    material = query.get("material") if isinstance(query, Mapping) else None
    shared = {key: value for key, value in result.items() if key not in ("products", "candidates", "warnings", "trace")}
    found = [(str(name), product) for name, product in products.items() if isinstance(product, Mapping) and "polyline" in product]
    lost = [f"{LABELS.get(name, name)}: {product.get('message')}" for name, product in _failed(products)]
    each = [shared | dict(product) | {"product": name, "label": LABELS.get(name, name), "asked": name == material} for name, product in found]
    return [entry | {"warnings": [*entry.get("warnings", []), *lost]} if lost else entry for entry in each] or [result]


def _failed(products: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    return [(str(name), product) for name, product in products.items() if isinstance(product, Mapping) and "error" in product]
