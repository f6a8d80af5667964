"""Options as keys of an experiment file, and their text for the library, which checks them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any, ClassVar


class Options:
    """Keys and values in the words of docs/experiment.md. What is not given has its default."""

    _tables: ClassVar[Mapping[str, str]] = {}

    def __init__(self, **keys: Any) -> None:
        self._keys = {key: value for key, value in keys.items() if value is not None}

    @property
    def keys(self) -> dict[str, Any]:
        """What was given."""
        return dict(self._keys)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{key}={value!r}' for key, value in self._keys.items())})"

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and toml(self) == toml(other)

    def __hash__(self) -> int:
        return hash((type(self), toml(self)))


def word_of(options: Options) -> str:
    """What experiment files call a class: point_to_point of PointToPoint."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", type(options).__name__).lower()


class Method(Options):
    """How an identification is made: signal chain, method and what is inferred."""

    def sections(self) -> dict[str, dict[str, Any]]:
        """The sections of an experiment file that say the same."""
        out: dict[str, dict[str, Any]] = {"signal": {}, "method": {"name": word_of(self)}}
        for key, value in self._keys.items():
            if key == "control":
                out["control"] = value.section()
            else:
                out[self._tables[key]][key] = value
        return out


def text_of(method: Method, who: str) -> str:
    """The sections of a method as TOML."""
    if not isinstance(method, Method):
        raise TypeError(f"{who}: the method is {method!r}, must be one such as rivid.Wls()")
    return "\n".join(f"{name} = {toml(keys)}" for name, keys in method.sections().items())


class Control(Options):
    """A control law."""

    def section(self) -> dict[str, Any]:
        """[control] of an experiment file that says the same."""
        return {"law": word_of(self), **self._keys}


class Motion(Options):
    """A reference motion."""

    def section(self) -> dict[str, Any]:
        """[reference] of an experiment file that says the same."""
        return {"type": word_of(self), **self._keys}


def toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, Options):
        value = value.keys
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, PathLike):
        return json.dumps(fspath(value), ensure_ascii=False)
    if isinstance(value, Mapping):
        inner = (f"{json.dumps(str(key))} = {toml(item)}" for key, item in value.items() if item is not None)
        return "{" + ", ".join(inner) + "}"
    if hasattr(value, "tolist"):  # arrays and numbers of NumPy
        return toml(value.tolist())
    return "[" + ", ".join(toml(item) for item in value) + "]"


def toml_keys(keys: Mapping[str, Any]) -> str:
    """Keys and values, one a line."""
    return "\n".join(f"{json.dumps(key)} = {toml(value)}" for key, value in keys.items() if value is not None)


def settings_of(settings: Mapping[str, Any] | None) -> list[str]:
    """Settings that are laid over an experiment file: {"signal.decimation": 5}."""
    return [f"{key}={toml(value)}" for key, value in (settings or {}).items()]
