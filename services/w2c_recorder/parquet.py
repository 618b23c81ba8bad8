"""Tables as Parquet."""

from collections.abc import Iterable, Mapping
from itertools import islice
from pathlib import Path

import pyarrow
from pyarrow.parquet import ParquetWriter

from w2c.errors import ConfigError
from w2c_recorder.columns import Kind, Row

ROWS_AT_ONCE = 5_000
"""In memory, and in one group of the file"""


def write_parquet(out: Path, kinds: Mapping[str, Kind], rows: Iterable[Row]) -> int:
    """Write a table; where a row has no cell, the table has null.

    Args:
        out: file.
        kinds: column -> type of its cells.
        rows: of the table.

    Returns:
        The number of rows.

    Raises:
        ConfigError: the file cannot be written.
    """
    types = {float: pyarrow.float64(), int: pyarrow.int64(), str: pyarrow.string()}
    schema = pyarrow.schema([(name, types[kind]) for name, kind in kinds.items()])
    pending, count = iter(rows), 0
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with ParquetWriter(out, schema, compression="zstd") as writer:
            while group := list(islice(pending, ROWS_AT_ONCE)):
                converted = [
                    {name: kinds[name](cell) for name, cell in row.items()} for row in group
                ]
                writer.write_table(pyarrow.Table.from_pylist(converted, schema=schema))
                count += len(group)
    except OSError as error:
        raise ConfigError(f"{out} cannot be written: {error}; choose another --out") from error
    return count
