"""The mapping of a file's columns to a log's columns: read from a mapping file, or guessed from the names."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import pyarrow as pa
import pyarrow.compute
import tomli_w
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from mjfriction.errors import LogError, suggestion
from mjfriction.record.log import CURRENT, EFFORT, KNOWN, POSITION, SET_WORDS, SUPPLY_PRESSURE, TEMPERATURE, VELOCITY
from mjfriction.record.ticks import TICKS, tick_of

TIME, SEGMENT = "time", "segment"
Finite = Annotated[float, Field(allow_inf_nan=False)]

TIMES = {"time", "t", "sec", "timestamp", "stamp", "clock", "seconds", "secs", "elapsed"}
SEGMENTS = {"segment", "run", "episode", "trial"}
QUANTITIES = {
    POSITION: {"position", "pos", "q", "angle", "theta"},
    VELOCITY: {"velocity", "vel", "qd", "dq", "speed", "omega", "qdot"},
    EFFORT: {"effort", "torque", "tau", "force", "moment", "trq", "eff"},
    CURRENT: {"current", "cur", "amp", "amps", "ampere", "iq"},
    TEMPERATURE: {"temperature", "temp"},
}
TURN = math.pi / 180.0
SCALES: dict[str, dict[str, float]] = {
    TIME: {"ms": 1e-3, "msec": 1e-3, "us": 1e-6, "ns": 1e-9, "nsec": 1e-9},
    POSITION: {"deg": TURN, "degree": TURN, "degrees": TURN, "mrad": 1e-3, "mm": 1e-3},
    VELOCITY: {
        "deg": TURN,
        "degree": TURN,
        "degrees": TURN,
        "degs": TURN,
        "rpm": math.pi / 30.0,
        "mrad": 1e-3,
        "mm": 1e-3,
    },
    EFFORT: {"nmm": 1e-3, "mnm": 1e-3, "kn": 1e3, "knm": 1e3},
    CURRENT: {"ma": 1e-3},
    TEMPERATURE: {},
}
"""What a unit in a column's name makes of its numbers, by the quantity that it can be a unit of."""
PLAIN_UNITS = {"rad", "rads", "s", "sec", "m", "nm", "n", "a", "c", "celsius"}
UNITS = PLAIN_UNITS.union(*SCALES.values())
GENERIC = {"joint", "joints", "link", "axis", "motor"}  # words of a joint's name that column names may leave out


class Source(BaseModel):
    """Where a column of a log comes from: a ``column`` of the file, times ``scale``, plus ``offset``, in SI units."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    column: str
    scale: Finite = 1.0
    offset: Finite = 0.0


@dataclass(frozen=True)
class Mapping:
    """The ``sources`` of a log's columns, by the columns' names."""

    sources: dict[str, Source]

    def applied(self, table: pa.Table, where: str) -> pa.Table:
        """Return a table with the log's columns in place of the file's; all others are left out.

        Raises :class:`LogError` for a column that the table lacks, or that is to be scaled and is not numeric.
        """
        names = [name.strip() for name in table.schema.names]
        table = table.rename_columns(names)
        columns = {}
        for own, source in self.sources.items():
            if source.column not in names:
                raise LogError(f"{where}: no column '{source.column}' for '{own}'{suggestion(source.column, names)}")
            values = table[source.column]
            if source.scale != 1.0 or source.offset != 0.0:
                try:
                    numbers = pyarrow.compute.cast(values, pa.float64(), safe=False)
                except (pa.ArrowInvalid, pa.ArrowNotImplementedError):
                    raise LogError(f"{where}: column '{source.column}' holds what is not a number") from None
                values = pyarrow.compute.add(pyarrow.compute.multiply(numbers, source.scale), source.offset)
            columns[own] = values
        return pa.table(columns)

    def text(self) -> str:
        """Return the mapping as the text of a mapping file."""
        plain = {
            own: source.column if source == Source(column=source.column) else source.model_dump(exclude_defaults=True)
            for own, source in self.sources.items()
        }
        return tomli_w.dumps(plain)


_TABLE = TypeAdapter(dict[str, Source | str])


def read_mapping(path: Path) -> Mapping:
    """Read a mapping file: TOML of ``"position.elbow" = "q3"``, or ``= { column = "q3", scale = 0.01745 }``.

    Raises :class:`LogError` for a file that cannot be read, and for names that no column of a log has.
    """
    try:
        table = _TABLE.validate_python(tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise LogError(f"{path}: no mapping file that can be read: {(error.strerror or str(error)).lower()}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: not valid TOML: {error}") from None
    except ValidationError as error:
        place = ".".join(str(part) for part in error.errors()[0]["loc"][:1])
        raise LogError(
            f"{path}: '{place}': a column's name is allowed, or a table of column, scale and offset; names with a dot "
            f'stand in quotes: "position.elbow" = "q3"'
        ) from None
    if not table:
        raise LogError(f"{path}: names no column; fill in a line for each, as docs/logs.md shows")
    for own in table:
        if own not in (TIME, SEGMENT, SUPPLY_PRESSURE) and own.partition(".")[0] not in KNOWN:
            raise LogError(f"{path}: '{own}' is no column of a log; allowed are time, segment and {', '.join(KNOWN)}")
    return Mapping({own: Source(column=one) if isinstance(one, str) else one for own, one in table.items()})


def guess_mapping(names: Sequence[str], joints: Sequence[str]) -> Mapping:
    """Guess the mapping from a table's column names: quantities by their usual words, joints by name or number.

    References and commands to a drive are not taken as measurements.  The guess is meant to be shown to the user.  Its
    :attr:`sources` hold what was found, and may lack a joint or the time.
    """
    found: dict[str, Source] = {}
    numbered: list[tuple[str, int, Source]] = []
    for name in names:
        words = _words(name)
        plain = [word for word in words if word not in UNITS or len(words) == 1]
        if set(words) & SET_WORDS:
            continue
        if len(plain) == 1 and plain[0] in TIMES:
            found.setdefault(TIME, Source(column=name, scale=_scale(TIME, words)))
        elif len(plain) == 1 and plain[0] in SEGMENTS:
            found.setdefault(SEGMENT, Source(column=name))
        else:
            quantity = _quantity(plain)
            if quantity is None:
                continue
            source = Source(column=name, scale=_scale(quantity, words))
            joint = _named(words, joints)
            if joint is not None:
                found.setdefault(f"{quantity}.{joint}", source)
            else:
                number = next((int(word) for word in reversed(plain) if word.isdigit()), None)
                if number is not None:
                    numbered.append((quantity, number, source))
    # Each quantity may number the joints from 0 or from 1: positions from 0 and torques from 1, for instance.
    first = {own: min(number for quantity, number, _ in numbered if quantity == own) for own, _, _ in numbered}
    for quantity, number, source in numbered:
        if number - first[quantity] < len(joints):
            found.setdefault(f"{quantity}.{joints[number - first[quantity]]}", source)
    return Mapping(found)


def clocked(guess: Mapping, table: pa.Table) -> Mapping:
    """Return a guess for a table's columns with the clock's unit, where its name states none, chosen by its usual step.

    The unit is seconds, or the one of milli-, micro- and nanoseconds that makes the log one of 10 Hz to 10 kHz.
    """
    source = guess.sources.get(TIME)
    if source is None or source.scale != 1.0:
        return guess
    column = table.column(source.column)
    if not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)) or len(column) < 2:
        return guess
    step = float(np.nanmedian(np.diff(column.to_numpy())))
    return Mapping({**guess.sources, TIME: source.model_copy(update={"scale": TICKS[tick_of(step)]})})


def template(names: Sequence[str], joints: Sequence[str]) -> str:
    """Return the text of a mapping file to fill in: every column that is needed, and the names in the file."""
    wanted = [TIME, *(f"{quantity}.{joint}" for joint in joints for quantity in (POSITION, EFFORT))]
    lines = ["# Take the '#' away and put in the column's name. The file's columns are:"]
    lines += [f"#   {name}" for name in names]
    lines += ['# A column in another unit: { column = "...", scale = 0.0174532925 } turns degrees into radians.', ""]
    return "\n".join([*lines, *(f'# "{own}" = "..."' for own in wanted)]) + "\n"


def _words(name: str) -> list[str]:
    # jointPos3_deg gives joint, pos, 3, deg; q[3] (deg) gives q, 3, deg; mA, degC and Nm are one word each.
    for unit in ("mA", "degC", "deg C", "Nmm", "mNm", "kNm", "kN", "Nm"):
        name = re.sub(rf"(?<![A-Za-z]){unit}(?![A-Za-z])", "celsius" if unit.startswith("deg") else unit.lower(), name)
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    parted = re.sub(r"(?<=[A-Za-z])(?=\d)|(?<=\d)(?=[A-Za-z])", " ", parted)
    return [word for word in re.split(r"[^a-z0-9]+", parted.lower()) if word]


def _scale(quantity: str, words: list[str]) -> float:
    return next((SCALES[quantity][word] for word in words if word in SCALES[quantity]), 1.0)


def _quantity(words: list[str]) -> str | None:
    # The q of vel_q1 and tau_q1 is the name of a joint; alone it means its position.  So positions are tried last.
    for quantity in (VELOCITY, EFFORT, CURRENT, TEMPERATURE, POSITION):
        if any(word in QUANTITIES[quantity] for word in words):
            return quantity
    return None


def _named(words: list[str], joints: Sequence[str]) -> str | None:
    inside = []
    for joint in joints:
        own = _words(joint)
        core = [word for word in own if word not in GENERIC]
        bare = [word for word in words if word not in GENERIC]
        # A number alone may count from 0 or from 1, so it identifies a joint only as part of the whole name.
        named = any(not word.isdigit() for word in core)
        if _holds(words, own) or (named and _holds(bare, core)):
            inside.append(joint)
    return max(inside, key=len, default=None)


def _holds(words: list[str], part: list[str]) -> bool:
    return any(words[i : i + len(part)] == part for i in range(len(words) - len(part) + 1))
