"""The documentation of the scene format is what the models say."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import BaseModel, ValidationError
from scene_pages import CONTACTS_PATH, PATH, SECTIONS, SNOWS_PATH, TABLES, document, with_table

from neve.scene.schema.material import Overrides, Snow
from neve.scene.schema.scene import Scene
from neve.scene.schema.snow_kinds import SNOWS
from neve.scene.values.allowed import source

MODELS = [Scene, Overrides, *(model for _, _, model in SECTIONS)]


def test_document_is_up_to_date() -> None:
    """docs/scene_format.md is the generated text; `python tools/scene_pages.py` writes it."""
    assert (Path(__file__).parents[3] / PATH).read_text(encoding="utf-8") == document()


@pytest.mark.parametrize("path", TABLES, ids=str)
def test_table_of_snows_is_up_to_date(path: Path) -> None:
    """The tables of docs/snows.md and docs/particles.md are the generated ones; the rest is free."""
    page = (Path(__file__).parents[3] / path).read_text(encoding="utf-8")
    assert with_table(page, TABLES[path]()) == page
    for name in SNOWS:
        text = {SNOWS_PATH: SNOWS[name].about, CONTACTS_PATH: f"`{SNOWS[name].law}`"}[path]
        assert f"| `{name}` | {text} |" in page


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_every_field_is_complete(model: type[BaseModel]) -> None:
    """Every field has a default, a meaning that ends as a sentence, a unit and a source."""
    for name, field in model.model_fields.items():
        assert not field.is_required(), name
        assert field.description, name
        assert field.description.endswith("."), name
        assert isinstance(field.json_schema_extra, dict), name
        assert set(field.json_schema_extra) - {"suffixes", "folder"} == {"unit", "source"}, name
        assert source(field), name


def test_overrides_have_the_keys_and_limits_of_snow() -> None:
    """A source's snow takes the same keys, each left out by default, and refuses what the scene's refuses."""
    assert list(Overrides.model_fields) == list(Snow.model_fields)
    assert Overrides().given() == {}
    for name, field in Snow.model_fields.items():
        bounds = [
            (getattr(m, k), k) for m in field.metadata for k in ("gt", "ge", "lt", "le") if hasattr(m, k)
        ]
        assert len(bounds) == (0 if isinstance(field.default, str) else 2), name
        outside = [b if k in ("gt", "lt") else b - 1 if k == "ge" else 2 * b for b, k in bounds]
        for value in [*outside, "of no kind"]:
            for model in (Overrides, Snow):
                with pytest.raises(ValidationError, match=rf"\n{name}\n"):
                    model.model_validate({name: value})
