// Python's door to the pictures: neve._render.
#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#ifdef _OPENMP
#include <omp.h>
#endif

#include <mutex>

#include "bind/arrays.hpp"
#include "bind/words.hpp"
#include "render/picture.hpp"
#include "render/spread.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace neve::bind;
using namespace neve::render;

namespace {

using Points = In<float, nb::shape<-1, 3>>;
using Numbers = In<float, nb::shape<-1>>;
using Triple = std::tuple<float, float, float>;

int known_level(int level) {
  if (level < 0 || level >= Density::levels) throw nb::value_error("level: from 0 to 5");
  return level;
}

Vec3f vec(const Triple& a) { return {std::get<0>(a), std::get<1>(a), std::get<2>(a)}; }

// Apply f to every point and return the numbers as an array.
template <class F>
auto each(const Points& x, F&& f) {
  std::vector<float> out(x.shape(0));
  for (std::size_t p = 0; p < out.size(); ++p) out[p] = f(Vec3f{x(p, 0), x(p, 1), x(p, 2)});
  return array(std::move(out), {x.shape(0)});
}

// Use this many threads while it lives; 0 leaves the choice to OpenMP.
class Threads {
 public:
  explicit Threads(int threads) {
#ifdef _OPENMP
    before_ = omp_get_max_threads();
    if (threads > 0) omp_set_num_threads(threads);
#else
    (void)threads;
#endif
  }
  ~Threads() {
#ifdef _OPENMP
    omp_set_num_threads(before_);
#endif
  }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

 private:
  int before_ = 1;
};

using SharedMesh = std::shared_ptr<Mesh>;

Solid solid_of(const std::string& shape, const Triple& position, const std::vector<float>& rotation,
               const Triple& half, const Triple& color, const std::string& surface_material, SharedMesh mesh,
               bool is_static) {
  if (rotation.size() != 9) throw nb::value_error("rotation has nine numbers, row by row");
  const std::vector<float>& r = rotation;
  neve::PlacedShape<float> place{};
  place.kind = neve::bind::value_of<neve::Shape>(shape, neve::shape_names, "shape");
  if (neve::is_sampled(place.kind) != bool(mesh))
    throw nb::value_error("mesh is given for shapes with samples, and only for them");
  place.centre = vec(position);
  place.half = vec(half);
  place.rotation = {{r[0], r[3], r[6]}, {r[1], r[4], r[7]}, {r[2], r[5], r[8]}};
  const auto material =
      neve::bind::value_of<SurfaceMaterial>(surface_material, surface_material_names, "surface_material");
  return make_solid(place, vec(color), material, is_static, std::move(mesh));
}

SharedMesh make_mesh(
    const nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>& vertices,
    const nb::ndarray<const std::int32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>& faces) {
  std::vector<neve::Point> points(vertices.shape(0));
  for (std::size_t v = 0; v < points.size(); ++v)
    points[v] = {vertices(v, 0), vertices(v, 1), vertices(v, 2)};
  std::vector<std::array<std::int32_t, 3>> corners(faces.shape(0));
  for (std::size_t f = 0; f < corners.size(); ++f) corners[f] = {faces(f, 0), faces(f, 1), faces(f, 2)};
  nb::gil_scoped_release release;
  return std::make_shared<Mesh>(points, corners);
}

SharedMesh make_terrain(
    const nb::ndarray<const float, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>& heights,
    const std::array<float, 2>& size) {
  nb::gil_scoped_release release;
  return std::make_shared<Mesh>(std::make_unique<const neve::HeightField>(
      heights.data(), std::int32_t(heights.shape(0)), std::int32_t(heights.shape(1)), size[0], size[1]));
}

// Water on a plane, with its own copy of the wetness.
struct HeldPuddle {
  Puddle puddle;
  std::vector<float> wet;
  Puddle seen() const {
    Puddle out = puddle;
    out.wet = wet;
    return out;
  }
};

HeldPuddle make_puddle(int solid, const std::array<float, 2>& origin, float cell,
                       const In<float, nb::shape<-1, -1>>& wet) {
  if (solid < 0) throw nb::value_error("solid is the number of a plane, from 0");
  if (!(cell > 0)) throw nb::value_error("cell is above zero");
  const int rows = int(wet.shape(0)), columns = int(wet.shape(1));
  return {{solid, origin[0], origin[1], cell, rows, columns, {}},
          std::vector<float>(wet.data(), wet.data() + wet.size())};
}

using Streaks = In<float, nb::shape<-1, 10>>;

std::span<const Streak> streaks_of(const Streaks& rows) {
  static_assert(sizeof(Streak) == 10 * sizeof(float));
  return {reinterpret_cast<const Streak*>(rows.data()), rows.shape(0)};
}

// Draw flakes over the light (h, w, 3) of a picture.
auto veil(const In<float, nb::shape<-1, -1, 3>>& light, const In<float, nb::shape<-1, -1>>& depth,
          const Streaks& rows) {
  const std::size_t h = light.shape(0), w = light.shape(1);
  if (depth.shape(0) != h || depth.shape(1) != w) throw nb::value_error("depth has a number for each pixel");
  float* out = nullptr;
  auto held = fresh(out, {h, w, 3});
  nb::gil_scoped_release release;
  Veil over;
  over.draw(int(w), int(h), streaks_of(rows), [&](int r, int c) {
    const float found = depth.data()[std::size_t(r) * w + std::size_t(c)];
    return found > 0 ? found : std::numeric_limits<float>::infinity();
  });
  for (std::size_t p = 0; p < h * w; ++p) {
    const float* from = light.data() + 3 * p;
    const Vec3f seen = over.over(int(p / w), int(p % w), {from[0], from[1], from[2]});
    out[3 * p] = seen.x, out[3 * p + 1] = seen.y, out[3 * p + 2] = seen.z;
  }
  return held;
}

// A painter that two Python threads can share: one picture at a time.
struct SharedPainter {
  Painter painter;
  std::mutex busy;
};

auto draw(SharedPainter& shared, const Points& x, const Numbers& J_P, float volume, float cell_size,
          const std::vector<Solid>& solids, int threads, const Numbers& water,
          const std::vector<HeldPuddle>& lying, const Streaks& falling) {
  if (water.shape(0) != 0 && water.shape(0) != x.shape(0))
    throw nb::value_error("water has one number per particle");
  if (J_P.shape(0) != 0 && J_P.shape(0) != x.shape(0))
    throw nb::value_error("J_P has one number per particle");
  if (!(volume > 0 && cell_size > 0)) throw nb::value_error("volume and cell_size are above zero");
  if (solids.size() > most_solids) throw nb::value_error("too many solids to draw");
  const std::vector<Vec3f> points = points_of(x);
  const Camera& camera = shared.painter.camera();
  std::vector<std::uint8_t> rgb(std::size_t(camera.width) * std::size_t(camera.height) * 3);
  {
    nb::gil_scoped_release release;
    const std::lock_guard lock(shared.busy);
    const Threads use(threads);
    std::vector<Puddle> puddles;
    for (const HeldPuddle& held : lying) puddles.push_back(held.seen());
    shared.painter.draw({points,
                         {J_P.data(), J_P.shape(0)},
                         {water.data(), water.shape(0)},
                         volume,
                         cell_size,
                         puddles,
                         streaks_of(falling)},
                        solids, rgb.data());
  }
  return array(std::move(rgb), {std::size_t(camera.height), std::size_t(camera.width), 3});
}

void bind_density(nb::module_& m) {
  nb::class_<Density>(m, "Density", "Volume fraction of snow on a pyramid of sparse grids.")
      .def(
          "__init__",
          [](Density* self, const Points& x, float volume, float cell_size) {
            new (self) Density(points_of(x), volume, cell_size);
          },
          "x"_a, "volume"_a, "cell_size"_a)
      .def(
          "total", [](const Density& d, int level) { return d.total(known_level(level)); }, "level"_a = 0,
          "Volume of the snow on a level [m3].")
      .def(
          "blocks", [](const Density& d, int level) { return d.level(known_level(level)).count(); },
          "level"_a = 0)
      .def(
          "sample",
          [](const Density& d, const Points& x, int level) {
            known_level(level);
            return each(x, [&](Vec3f p) { return d.sample(p, level); });
          },
          "x"_a, "level"_a = 0, "Volume fraction at the points [1].")
      .def(
          "sun",
          [](const Density& d, const Points& x, const Triple& sun) {
            return each(
                x, [&](Vec3f p) { return std::exp(-sun_path(d, p, normalize(vec(sun)), 0.0f, 0.0f).far); });
          },
          "x"_a, "sun"_a, "Share of the sun that reaches the points through the snow [1].")
      .def(
          "sky",
          [](const Density& d, const Points& x, const Triple& normal) {
            return each(x, [&](Vec3f p) { return sky_light(d, p, normalize(vec(normal)), 0.0f, 0.0f); });
          },
          "x"_a, "normal"_a, "Share of the open sky's light on a surface at the points [1].")
      .def(
          "buried",
          [](const Density& d, const Points& x, const Triple& eye) {
            const Burial burial(d, vec(eye));
            return each(x, [&](Vec3f p) { return burial.buried(p) ? 1.0f : 0.0f; });
          },
          "x"_a, "eye"_a, "1 where snow hides a point from the eye, else 0.")
      .def(
          "deep",
          [](const Density& d, const Points& x, const Triple& eye) {
            const Burial burial(d, vec(eye));
            return each(x, [&](Vec3f p) { return burial.deep(p) ? 1.0f : 0.0f; });
          },
          "x"_a, "eye"_a, "1 where the block around a point says that snow hides it, else 0.");
}

// Let the light (h, w, 3) of a picture spread in its snow.
auto spread(const In<float, nb::shape<-1, -1, 3>>& light, const In<float, nb::shape<-1, -1>>& snow,
            const In<float, nb::shape<-1, -1>>& depth, const In<float, nb::shape<-1, -1>>& radius,
            const In<float, nb::shape<2, 3, -1>>& taps, float share, float thick) {
  const std::size_t h = light.shape(0), w = light.shape(1), count = taps.shape(2);
  for (const auto* a : {&snow, &depth, &radius})
    if (a->shape(0) != h || a->shape(1) != w)
      throw nb::value_error("snow, depth and radius have a number for each pixel");
  if (!(thick > 0)) throw nb::value_error("thick is above zero");
  SpreadTaps of[3];
  for (std::size_t c = 0; c < 3; ++c)
    of[c] = {taps.data() + c * count, taps.data() + (3 + c) * count, int(count)};
  float* out = nullptr;
  auto held = fresh(out, {h, w, 3});
  nb::gil_scoped_release release;
  spread_light({light.data(), snow.data(), depth.data(), radius.data(), std::int64_t(h), std::int64_t(w)}, of,
               share, thick, out);
  return held;
}

void bind_painter(nb::module_& m) {
  nb::class_<HeldPuddle>(m, "Puddle", "Melt water that lies on a plane.")
      .def(nb::new_(&make_puddle), "solid"_a, "origin"_a, "cell"_a, "wet"_a);
  nb::class_<SharedPainter>(m, "Painter", "Draw one frame after the other with the same camera and light.")
      .def(
          "__init__",
          [](SharedPainter* self, const Camera& camera, const Light& light, std::uint32_t leaf) {
            if (leaf < 1) throw nb::value_error("leaf is 1 or more");
            new (self) SharedPainter{Painter(camera, light, leaf), {}};
          },
          "camera"_a, "light"_a, "leaf"_a = neve::BvhBuilder::leaf_most)
      .def("draw", &draw, "x"_a, "J_P"_a, "volume"_a, "cell_size"_a, "solids"_a, "threads"_a, "water"_a,
           "puddles"_a, "falling"_a, "Draw particles and solids; return height x width x 3 bytes.");
}

}  // namespace

NB_MODULE(_render, m) {
  nb::set_leak_warnings(false);  // what lives until the interpreter ends is no news for who runs a command
  m.doc() = "Light and draw particles.";
  bind_density(m);
  m.def(
      "surface_materials", [] { return neve::bind::tuple_of(surface_material_names); },
      "Words of what surfaces are made of.");
  m.def("spread", &spread, "light"_a, "snow"_a, "depth"_a, "radius"_a, "taps"_a, "share"_a, "thick"_a,
        "Light of a picture after it has spread in its snow.");
  m.def("veil", &veil, "light"_a, "depth"_a, "streaks"_a,
        "Light of a picture over which flakes are drawn, the farthest first.");
  nb::class_<Camera>(m, "Camera", "A pinhole camera.")
      .def(
          "__init__",
          [](Camera* self, const Triple& position, const Triple& target, const Triple& up, float fov,
             int width, int height) {
            if (width < 1 || height < 1 || width > 16384 || height > 16384)
              throw nb::value_error("width and height are 1 to 16384 pixels");
            new (self) Camera(vec(position), vec(target), vec(up), fov, width, height);
          },
          "position"_a, "target"_a, "up"_a, "fov"_a, "width"_a, "height"_a)
      .def(
          "project",
          [](const Camera& camera, const Triple& p) {
            const Vec3f at = camera.project(vec(p));
            return Triple{at.x, at.y, at.z};
          },
          "point"_a, "Return column, row [px] and depth [m].");
  nb::class_<Light>(m, "Light", "Sun and sky.")
      .def(
          "__init__",
          [](Light* self, const Triple& sun, const Triple& sun_color, const Triple& sky_color) {
            new (self) Light{normalize(vec(sun)), vec(sun_color), vec(sky_color)};
          },
          "sun"_a, "sun_color"_a, "sky_color"_a);
  nb::class_<Mesh>(m, "Mesh", "Triangles, ready to be drawn.")
      .def(nb::new_(&make_mesh), "vertices"_a, "faces"_a)
      .def_static("terrain", &make_terrain, "heights"_a, "size"_a);
  nb::class_<Solid>(m, "Solid", "A collider or a body, drawn.")
      .def(
          "__init__",
          [](Solid* self, const std::string& shape, const Triple& position,
             const std::vector<float>& rotation, const Triple& half, const Triple& color,
             const std::string& surface_material, SharedMesh mesh, bool is_static) {
            new (self) Solid(solid_of(shape, position, rotation, half, color, surface_material,
                                      std::move(mesh), is_static));
          },
          "shape"_a, "position"_a, "rotation"_a, "half"_a, "color"_a, "surface_material"_a = "paint",
          "mesh"_a = nb::none(), "is_static"_a = false);
  bind_painter(m);
}
