"""The parquet files of a dataset: frames, episodes, tasks, with the metadata that their readers look for."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from farhand.export.lerobot.features import Column

TASK, TASK_INDEX = "task", "task_index"


def frame_table(columns: Mapping[str, Column]) -> pa.Table:
    """Frames by column; a column (n, k) is a list of fixed size."""
    arrays = {name: _array(values) for name, values in columns.items()}
    described = json.dumps({"info": {"features": {name: _described(values) for name, values in columns.items()}}})
    return pa.table(arrays).replace_schema_metadata({"huggingface": described})


def write_frames(path: Path, episodes: Iterable[pa.Table]) -> None:
    """Frames as one row group for each episode, so that one can be read alone."""
    writer: pq.ParquetWriter | None = None
    path.parent.mkdir(parents=True, exist_ok=True)
    for table in episodes:
        writer = writer or pq.ParquetWriter(path, table.schema, compression="snappy")
        writer.write_table(table)
    if writer is not None:
        writer.close()


def read_frames(path: Path) -> dict[str, Column]:
    """Frames by column, as `frame_table` was given them."""
    table = pq.read_table(path)
    return {name: _values(table.column(name)) for name in table.column_names}


def write_tasks(path: Path, tasks: Sequence[str]) -> None:
    """The tasks' sentences, as a table that pandas reads with them as its index."""
    table = pa.table({TASK_INDEX: pa.array(range(len(tasks)), pa.int64()), TASK: pa.array(tasks, pa.string())})
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(table.replace_schema_metadata({"pandas": json.dumps(_pandas_index())}), path)


def write_episodes(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """A row for each episode; every row has the same keys."""
    path.parent.mkdir(parents=True, exist_ok=True)
    nullable = {"success": pa.bool_()}
    arrays = {name: pa.array([row[name] for row in rows], nullable.get(name)) for name in rows[0]}
    pq.write_table(pa.table(arrays), path)


def _array(values: Column) -> pa.Array:
    if values.ndim == 1:
        return pa.array(values)
    return pa.FixedSizeListArray.from_arrays(pa.array(np.ascontiguousarray(values).ravel()), values.shape[1])


def _values(column: pa.ChunkedArray) -> Column:
    whole = column.combine_chunks()
    if isinstance(whole, pa.FixedSizeListArray):
        flat: Column = whole.flatten().to_numpy()
        return flat.reshape(len(whole), -1)
    values: Column = whole.to_numpy()
    return values


def _described(values: Column) -> dict[str, Any]:
    """A column in the words of the library `datasets`."""
    value = {"dtype": values.dtype.name, "_type": "Value"}
    return value if values.ndim == 1 else {"feature": value, "length": values.shape[1], "_type": "List"}


def _pandas_index() -> dict[str, Any]:
    """Build what pandas wants to know of a table whose index is the task."""

    def column(name: str, kind: str, numpy_type: str) -> dict[str, Any]:
        return {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy_type, "metadata": None}

    return {
        "index_columns": [TASK],
        "column_indexes": [
            {"name": None, "field_name": None, "pandas_type": "unicode", "numpy_type": "object", "metadata": None}
        ],
        "columns": [column(TASK_INDEX, "int64", "int64"), column(TASK, "unicode", "object")],
        "creator": {"library": "pyarrow", "version": pa.__version__},
        "pandas_version": "2.2.3",
    }
