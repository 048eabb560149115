"""Regenerate the JSON Schema of report.json.  Run: python scripts/make_schema.py"""

from __future__ import annotations

import json
from pathlib import Path

from mjfriction.report.result import Report


def schema() -> str:
    return (
        json.dumps(Report.model_json_schema(by_alias=True, mode="serialization"), indent=2, ensure_ascii=False) + "\n"
    )


if __name__ == "__main__":
    target = Path(__file__).resolve().parent.parent / "mjfriction/report/report.schema.json"
    target.write_text(schema(), encoding="utf-8")
