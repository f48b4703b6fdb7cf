"""Roles of shapes: snow at the start, a collider that meets it, a body that it moves."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, Union

from pydantic import Field, GetCoreSchemaHandler, create_model
from pydantic_core import CoreSchema

from neve.scene.schema.file_shapes import FROM_FILES
from neve.scene.schema.shapes import FORMULAS, Shape
from neve.scene.values.fields import CONTACT, MODES, Color, Finish, Part, Real, Switch, entry

SHAPES: dict[str, type[Shape]] = {
    shape.model_fields["shape"].default: shape for shape in (*FORMULAS, *FROM_FILES)
}
"""Every shape by its word, in the order of messages and documents."""


class Role(Shape):
    """Hold the keys that a shape has in a role; `forms` combines them.

    Attributes:
        role: its word in `Shape.roles`
    """

    role: ClassVar[str]

    @classmethod
    def of(cls, shape: str, **keys: Any) -> Self:
        """Return a part of a scene in this role, such as Source.of("sphere", radius=0.3).

        Errors: ValueError for a shape that it cannot have; pydantic.ValidationError for its keys.
        """
        known = forms(cls)
        if shape not in known:
            raise ValueError(f'a {cls.role} has no shape "{shape}": use one of {", ".join(known)}')
        return known[shape](**keys)


R = TypeVar("R", bound=Role)
_made: dict[type[Role], dict[str, Any]] = {}


def forms(role: type[R]) -> dict[str, type[R]]:
    """Return the models of `role` by the word of their shape, each with the keys of both."""
    if role not in _made:
        _made[role] = {
            word: create_model(
                f"{shape.__name__}{role.__name__}",
                __base__=(role, shape),
                __doc__=f"{shape.__doc__}\n\n{role.__doc__}",
                __module__=role.__module__,
            )
            for word, shape in SHAPES.items()
            if role.role in shape.roles
        }
    return _made[role]


class OneOfItsShapes:
    """Mark an annotation of a role: a value is one of its models, and `shape` says which."""

    def __get_pydantic_core_schema__(self, role: type[Role], handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of the union of the role's models."""
        union: Any = Union[tuple(forms(role).values())]  # noqa: UP007
        tagged: Any = Annotated[union, Field(discriminator="shape")]
        return handler.generate_schema(tagged)


class Surface(Part):
    """Say what the surface of a solid is to snow and in the film."""

    mode: Literal["separate", "slip", "sticky"] = entry("separate", MODES, "", CONTACT)
    mu_c: Real = entry(
        0.5, "Coulomb friction between snow and this solid; not used when sticky.", "1", ge=0, le=100
    )
    color: Color | None = entry(None, "Red, green and blue in the film; left out, a colour is chosen.", "1")
    finish: Finish | None = entry(
        None,
        "What the surface in the film is made of; left out, paint, and frozen ground of a plane or terrain "
        "without a colour.",
        "",
    )
    visible: Switch = entry(True, "Whether the film shows it.", "")
