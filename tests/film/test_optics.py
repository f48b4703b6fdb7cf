"""Light in snow: formulas against their integrals, and the media of the looks in Mitsuba against them."""

import math

import numpy as np
import pytest

from neve.render.path_tracing.looks import KINDS, PHASES, QUALITIES, REFERENCE, Medium, capped, similar
from neve.render.path_tracing.optics import cornette_shanks, slab_reflectance
from neve.render.path_tracing.tracer import MOST_EXTINCTION, Tracer, medium_of, paths_in, phase_of
from neve.scene.schema.scene import Numerics, Scene, Source

COSINES, WEIGHTS = np.polynomial.legendre.leggauss(200)


@pytest.mark.parametrize("g", [-0.6, 0.0, 0.5, 0.85])
def test_the_phase_function_is_normalised(g):
    """The integral of Cornette and Shanks' over all directions is 1 and its mean cosine the medium's, 0.6 g
    (4 + g^2) / (2 + g^2) (Gauss-Legendre over the cosine)."""
    p = 2 * math.pi * WEIGHTS * cornette_shanks(COSINES, g)
    assert p.sum() == pytest.approx(1.0, rel=1e-9)
    mean = Medium(1.0, (1.0, 1.0, 1.0), g, "cornette_shanks").mean_cosine
    assert p @ COSINES == pytest.approx(mean, abs=1e-9)
    assert mean == pytest.approx(g * 0.6 * (4 + g * g) / (2 + g * g))


def test_similar_medium_keeps_what_light_sees():
    """The isotropic medium has, per colour, the same s = sqrt((1 - w) / (1 - g w)) of a thick slab, and
    the mean of the same sigma_t (1 - g w)."""
    like = similar(REFERENCE)
    assert like.g == 0.0
    for w, omega in zip(REFERENCE.albedo, like.albedo, strict=True):
        assert slab_reflectance(omega) == pytest.approx(slab_reflectance(w, REFERENCE.g), abs=1e-12)
    reduced = [REFERENCE.extinction * (1 - REFERENCE.g * w) for w in REFERENCE.albedo]
    assert like.extinction == pytest.approx(np.mean(reduced))
    assert capped(like, 100.0) == Medium(100.0, like.albedo)


def test_known_reflectances():
    """Values of the formula: 1 without absorption, 0.486 for w = 0.95 and g = 0.5, 0.360 for 0.9 and 0.5."""
    assert slab_reflectance(1.0) == 1.0
    assert slab_reflectance(0.95, 0.5) == pytest.approx(0.486, abs=1e-3)
    assert slab_reflectance(0.9, 0.5) == pytest.approx(0.360, abs=1e-3)


@pytest.fixture
def mi():
    pytest.importorskip("mitsuba", reason="pip install mitsuba mitsuba-oidn")
    from neve.render.path_tracing.engine import mitsuba

    return mitsuba()


@pytest.mark.parametrize("phase", PHASES)
def test_light_is_turned_by_the_angles_of_its_phase_function(mi, phase):
    """Scattered by the medium of a picture, light goes on at the mean cosine of the phase function, forward
    for g > 0, to the noise of 4,000 scatterings (deviation 0.5)."""
    medium = Medium(1.0, (1.0, 1.0, 1.0), 0.5, phase)
    function, at = mi.load_dict(phase_of(medium)), mi.MediumInteraction3f()
    at.wi, at.sh_frame = [0, 0, 1], mi.Frame3f([0, 0, 1])  # where the light came from
    numbers = np.random.default_rng(9).random((4000, 3))
    context = mi.PhaseFunctionContext()
    turned = [-function.sample(context, at, a, [b, c])[0].z for a, b, c in numbers.tolist()]
    assert np.mean(turned) == pytest.approx(medium.mean_cosine, abs=4 * 0.5 / math.sqrt(4000))


def box_of(mi, medium, half):
    """A box of a medium behind an open boundary, its top at z = 0."""
    place = mi.ScalarTransform4f().translate([0, 0, -half[2]]).scale(list(half))
    return {"type": "cube", "to_world": place, "bsdf": {"type": "null"}, "interior": medium_of(medium)}


def mean_of(mi, medium, half, samples):
    """Mean of the picture of a box of a medium under a white sky, seen from above, (3,)."""
    box, sensor = box_of(mi, medium, half), looking_down(mi)
    film = {
        "type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "pixel_format": "rgb",
        "component_format": "float32",
    }  # fmt: skip
    sampler = {"type": "independent", "sample_count": samples}
    scene = {
        "type": "scene", "box": box, "sky": {"type": "constant", "radiance": 1.0},
        "sensor": {**sensor, "film": film, "sampler": sampler},
        "integrator": paths_in(medium),
    }  # fmt: skip
    return np.array(mi.render(mi.load_dict(scene), seed=3)).ravel()


def looking_down(mi, height=1.0, at=(0, 0, 0)):
    place = mi.ScalarTransform4f().look_at([at[0], at[1], height], list(at), [0, 1, 0])
    return {"type": "perspective", "fov": 1.0, "to_world": place, "near_clip": 1e-4}


def meter(mi):
    """Measures what the top of a box sends back into all directions, weighted with the cosine."""
    place = mi.ScalarTransform4f().translate([0, 0, 1e-3]).rotate([1, 0, 0], 180).scale(1e-3)
    return {"type": "rectangle", "to_world": place, "bsdf": {"type": "null"}}


def reflectance(mi, medium, samples, wide):
    """Share of diffuse light that the top of a cube of half edge `wide` [m] sends back, per colour."""
    box = box_of(mi, medium, (wide, wide, wide))
    # By reciprocity rays that leave the eye with the cosine's weights do what diffuse light does.
    film = {"type": "irradiancemeter"}
    held = {**meter(mi), "sensor": {**film, **_film(samples)}}
    scene = {
        "type": "scene", "box": box, "sky": {"type": "constant", "radiance": 1.0}, "meter": held,
        "integrator": paths_in(medium),
    }  # fmt: skip
    return np.array(mi.render(mi.load_dict(scene), seed=5)).ravel() / math.pi


def _film(samples):
    return {
        "film": {
            "type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "independent", "sample_count": samples},
    }  # fmt: skip


def test_what_absorbs_dims_as_beer_and_lambert_say(mi):
    """Through a depth d of a medium that only absorbs T = exp(-sigma_t d) of the light behind is left."""
    thick, extinction = 0.3, 4.0
    seen = mean_of(mi, Medium(extinction, (0.0, 0.0, 0.0)), (1.0, 1.0, 0.5 * thick), 60_000)
    assert seen == pytest.approx(np.exp(-extinction * thick), rel=0.02)


@pytest.mark.parametrize("g", [0.0, 0.5])
def test_a_white_medium_under_a_white_sky_is_not_seen(mi, g):
    """Nothing is lost or made in a medium of albedo 1: it is as bright as the sky (white furnace), to
    the noise of these paths, which go as those of the pictures do."""
    assert mean_of(mi, Medium(12.0, (1.0, 1.0, 1.0), g), (0.4, 0.4, 0.3), 25_000) == pytest.approx(
        np.ones(3), rel=0.02
    )


def test_thick_white_snow_loses_no_light(mi):
    """Nor does a block of 80 mean free paths, in which light is scattered hundreds of times."""
    assert mean_of(mi, Medium(100.0, (1.0, 1.0, 1.0)), (0.4, 0.4, 0.4), 6_000) == pytest.approx(
        np.ones(3), rel=0.03
    )


def test_thick_snow_sends_back_what_the_formula_says(mi):
    """Diffuse reflectance of a thick box, for three albedos at once, within 2 % of van de Hulst's formula."""
    medium = Medium(100.0, (0.9, 0.95, 0.985), 0.5)
    expected = [slab_reflectance(w, medium.g) for w in medium.albedo]
    assert reflectance(mi, medium, 60_000, 4.0) == pytest.approx(expected, rel=0.02)


def test_the_similar_medium_sends_back_what_the_reference_does(mi):
    """Similarity: the mean over red, green and blue of what a crumb of 1 cm sends back agrees within 2 %."""
    reference, like = (reflectance(mi, m, 100_000, 0.005).mean() for m in (REFERENCE, similar(REFERENCE)))
    assert like == pytest.approx(reference, rel=0.02)


@pytest.mark.parametrize("dx", [0.02, 0.005])
def test_the_fast_look_sends_back_what_the_reference_does(mi, dx):
    """Its own medium, whose extinction is capped, does so for snow of many grid spacings, which is thick to
    light in both: within 2 % on average over the colours, for a block of 16 spacings."""
    quality = QUALITIES["final"]
    scene = Scene(sources=(Source.of("sphere"),), numerics=Numerics(dx=dx))
    fast = Tracer(scene, quality, "fast", KINDS["fresh"]).medium()
    assert fast.extinction <= MOST_EXTINCTION < similar(REFERENCE).extinction
    found, reference = (reflectance(mi, m, 20_000, 8 * dx).mean() for m in (fast, REFERENCE))
    assert found == pytest.approx(reference, rel=0.02)
