"""The documentation of the scene format is what the models say."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import BaseModel

from neve.scene.allowed import source
from neve.scene.document import PATH, SECTIONS, document
from neve.scene.scene import Scene
from neve.scene.snow import Overrides, Snow

MODELS = [Scene, Overrides, *(model for _, _, model in SECTIONS)]


def test_document_is_up_to_date() -> None:
    """docs/scene_format.md is the generated text; `python -m neve.scene.document` writes it."""
    assert (Path(__file__).parents[2] / PATH).read_text(encoding="utf-8") == document()


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_every_field_is_complete(model: type[BaseModel]) -> None:
    """Every field has a default, a meaning that ends as a sentence, a unit and a source."""
    for name, field in model.model_fields.items():
        assert not field.is_required(), name
        assert field.description, name
        assert field.description.endswith("."), name
        assert isinstance(field.json_schema_extra, dict), name
        assert set(field.json_schema_extra) == {"unit", "source"}, name
        assert source(field), name


def test_overrides_have_the_keys_and_limits_of_snow() -> None:
    """A source's snow takes the same keys, within the same limits, as the scene's."""
    assert list(Overrides.model_fields) == list(Snow.model_fields)
    for name, field in Snow.model_fields.items():
        limits = [m for m in field.metadata if not hasattr(m, "strict")]
        assert [m for m in Overrides.model_fields[name].metadata if not hasattr(m, "strict")] == limits, name
