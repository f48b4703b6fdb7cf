// Python's door to surfaces: neve._surface.
#include <nanobind/stl/tuple.h>

#include "bind/arrays.hpp"
#include "surface/carry.hpp"
#include "surface/grains.hpp"
#include "surface/nets.hpp"
#include "surface/stretched.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace neve::bind;
using namespace neve::surface;

namespace {

using Points = In<float, nb::shape<-1, 3>>;
using Numbers = In<float, nb::shape<-1>>;
using Names = nb::ndarray<const std::int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

// Points as they lie in an array: three numbers each, without a gap.
std::span<const Vec3f> vectors(const Points& x) {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  return {reinterpret_cast<const Vec3f*>(x.data()), x.shape(0)};
}

void check(const Points& x, const Numbers& amounts, float cell_size) {
  if (!(cell_size > 0 && cell_size < 1e9f)) throw nb::value_error("cell_size is above zero");
  if (amounts.shape(0) != 1 && amounts.shape(0) != x.shape(0))
    throw nb::value_error("amounts has one number, or one for each point");
}

void make_points(Field* self, const Points& x, const Numbers& amounts, float cell_size, int blurs) {
  check(x, amounts, cell_size);
  if (blurs < 0 || blurs > 8) throw nb::value_error("blurs: from 0 to 8");
  nb::gil_scoped_release release;
  new (self) Field(of_points(vectors(x), {amounts.data(), amounts.shape(0)}, cell_size, blurs));
}

// Density of points, and their momentum (b, 4, 4, 4, 3) on its blocks.
auto make_moments(const Points& x, const Numbers& amounts, const Points& v, float cell_size) {
  check(x, amounts, cell_size);
  if (v.shape(0) != x.shape(0)) throw nb::value_error("v has a row for each point");
  Moments found{{Blocks(cell_size)}, {}};
  std::vector<float> out;
  std::size_t n = 0;
  {
    nb::gil_scoped_release release;
    found = moments(vectors(x), {amounts.data(), amounts.shape(0)}, vectors(v), cell_size);
    n = std::size_t(found.density.blocks.count());
    constexpr int side = Blocks::side;
    constexpr std::size_t cells = side * side * side;
    out.resize(n * cells * 3);
#pragma omp parallel for schedule(static)
    for (std::int64_t b = 0; b < std::int64_t(n); ++b)
      for (int c = 0; c < 3; ++c) {
        const float* values = found.flow[std::size_t(c)].values(int(b));
        float* to = out.data() + std::size_t(b) * cells * 3 + c;
        for (int i = 0; i < side; ++i)
          for (int j = 0; j < side; ++j)
            for (int k = 0; k < side; ++k, to += 3) *to = values[Blocks::at(i, j, k)];
      }
  }
  constexpr std::size_t side = Blocks::side;
  return nb::make_tuple(std::move(found.density), array(std::move(out), {n, side, side, side, 3}));
}

Field balls(const Points& x, const Numbers& amounts, float radius, float cell_size) {
  check(x, amounts, cell_size);
  if (!(radius > 0 && radius <= 64 * cell_size)) throw nb::value_error("radius: above 0, up to 64 cells");
  nb::gil_scoped_release release;
  return of_balls(vectors(x), {amounts.data(), amounts.shape(0)}, radius, cell_size);
}

auto blocks(const Field& field) {
  std::vector<std::int32_t> out;
  out.reserve(3 * std::size_t(field.blocks.count()));
  for (int b = 0; b < field.blocks.count(); ++b) {
    const Int3 w = field.blocks.where(b);
    out.insert(out.end(), {w.x, w.y, w.z});
  }
  return array(std::move(out), {std::size_t(field.blocks.count()), 3});
}

auto values(const Field& field) {
  constexpr std::size_t side = Blocks::side;
  const auto n = std::size_t(field.blocks.count());
  std::vector<float> out;
  out.reserve(n * side * side * side);
  for (int b = 0; b < field.blocks.count(); ++b)
    for (int i = 0; i < Blocks::side; ++i)
      for (int j = 0; j < Blocks::side; ++j) {
        const float* row = field.blocks.values(b) + Blocks::at(i, j, 0);
        out.insert(out.end(), row, row + Blocks::side);
      }
  return array(std::move(out), {n, side, side, side});
}

auto sample(const Field& field, const Points& x) {
  float* out = nullptr;
  auto held = fresh(out, {x.shape(0)});
  const std::span<const Vec3f> at = vectors(x);
  nb::gil_scoped_release release;
#pragma omp parallel for schedule(static)
  for (std::int64_t p = 0; p < std::int64_t(at.size()); ++p) out[p] = field.sample(at[std::size_t(p)]);
  return held;
}

auto surface(const Field& field, float level) {
  if (!(level > 0)) throw nb::value_error("level is above zero");
  Triangles found;
  {
    nb::gil_scoped_release release;
    found = Nets(field, level).take();
  }
  const std::size_t n = found.vertices.size() / 3, m = found.faces.size() / 3;
  return nb::make_tuple(array(std::move(found.vertices), {n, 3}), array(std::move(found.normals), {n, 3}),
                        array(std::move(found.faces), {m, 3}));
}

using Matrices = In<float, nb::shape<-1, 3, 3>>;

// Matrices lie in arrays row by row.
Mat3f matrix(const float* a) { return {{a[0], a[3], a[6]}, {a[1], a[4], a[7]}, {a[2], a[5], a[8]}}; }
void put(const Mat3f& m, float* a) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a[3 * i + j] = m(i, j);
}

Field stretched(const Points& x, const Numbers& amounts, const Matrices& S, float width, float cell_size,
                int blurs) {
  check(x, amounts, cell_size);
  if (blurs < 0 || blurs > 8) throw nb::value_error("blurs: from 0 to 8");
  if (S.shape(0) != x.shape(0)) throw nb::value_error("stretch has a matrix for each point");
  if (!(width > 0)) throw nb::value_error("width is above zero");
  for (std::size_t p = 0; p < x.shape(0); ++p)
    for (int a = 0; a < 3; ++a)
      if (!(kernel_reach(matrix(S.data() + 9 * p), a) * width <= most_kernel_cells * cell_size))
        throw nb::value_error("kernels reach up to 64 cells");
  nb::gil_scoped_release release;
  const float* from = S.data();
  return of_stretched(
      vectors(x), {amounts.data(), amounts.shape(0)}, [&](std::size_t p) { return matrix(from + 9 * p); },
      width, cell_size, blurs);
}

auto make_grains(const Points& x, const Names& id, const Numbers& lone, const Matrices& offset, float spacing,
                 int count) {
  if (id.shape(0) != x.shape(0) || lone.shape(0) != x.shape(0))
    throw nb::value_error("id and lone have one number for each particle");
  if (offset.shape(0) != x.shape(0) && offset.shape(0) != 1)
    throw nb::value_error("offset has one matrix, or one for each particle");
  if (!(spacing > 0) || count < 1 || count > 512) throw nb::value_error("spacing is above 0, count 1 to 512");
  float* out = nullptr;
  auto held = fresh(out, {x.shape(0) * std::size_t(count), 3});
  const std::size_t each = offset.shape(0) > 1 ? 9 : 0;
  const float* first = offset.data();
  nb::gil_scoped_release release;
  grains(
      vectors(x), {id.data(), id.shape(0)}, {lone.data(), lone.shape(0)},
      [&](std::size_t p) { return matrix(first + each * p); }, spacing, count, reinterpret_cast<Vec3f*>(out));
  return held;
}

auto make_gradients(const Points& first, const Points& x, const In<std::int32_t, nb::shape<-1, -1>>& near) {
  const std::size_t n = x.shape(0), count = near.shape(1);
  if (first.shape(0) != n || near.shape(0) != n)
    throw nb::value_error("first, x and near have a row for each particle");
  for (std::size_t k = 0; k < n * count; ++k)
    if (near.data()[k] < 0 || std::size_t(near.data()[k]) >= n) throw nb::value_error("near: rows of x");
  float* out = nullptr;
  auto held = fresh(out, {n, 3, 3});
  nb::gil_scoped_release release;
  const std::vector<Mat3f> found = gradients(vectors(first), vectors(x), {near.data(), n * count}, count);
  for (std::size_t p = 0; p < n; ++p) put(found[p], out + 9 * p);
  return held;
}

auto make_carried(const Matrices& F) {
  const std::size_t n = F.shape(0);
  float *turn = nullptr, *offset = nullptr;
  auto turns = fresh(turn, {n, 3, 3}), offsets = fresh(offset, {n, 3, 3});
  {
    const float* from = F.data();
    nb::gil_scoped_release release;
#pragma omp parallel for schedule(static)
    for (std::int64_t p = 0; p < std::int64_t(n); ++p) {
      const Carried found = carried(matrix(from + 9 * p));
      put(found.turn, turn + 9 * p);
      put(found.offset, offset + 9 * p);
    }
  }
  return nb::make_tuple(turns, offsets);
}

}  // namespace

NB_MODULE(_surface, m) {
  nb::set_leak_warnings(false);  // what lives until the interpreter ends is no news for who runs a command
  m.doc() = "Make fields, surfaces and grains of particles.";
  nb::class_<Field>(m, "Field", "A scalar on a sparse grid of cells.")
      .def("__init__", &make_points, "x"_a, "amounts"_a, "cell_size"_a, "blurs"_a = 0)
      .def_static("balls", &balls, "x"_a, "amounts"_a, "radius"_a, "cell_size"_a)
      .def_static("stretched", &stretched, "x"_a, "amounts"_a, "stretch"_a, "width"_a, "cell_size"_a,
                  "blurs"_a = 0)
      .def_static("moments", &make_moments, "x"_a, "amounts"_a, "v"_a, "cell_size"_a)
      .def_prop_ro("cell_size", [](const Field& field) { return field.blocks.cell_size(); })
      .def_prop_ro("origin", [](const Field& f) { return std::tuple{f.origin.x, f.origin.y, f.origin.z}; })
      .def("blocks", &blocks, "Places of the blocks, in blocks.")
      .def("values", &values, "Values of the cells of each block.")
      .def("sample", &sample, "x"_a, "Value at points, between the centres of cells.")
      .def("surface", &surface, "level"_a, "Vertices, normals and faces of the surface of that value.");
  m.def("grains", &make_grains, "x"_a, "id"_a, "lone"_a, "offset"_a, "spacing"_a, "count"_a,
        "Grains of particles.");
  m.def("gradients", &make_gradients, "first"_a, "x"_a, "near"_a,
        "Deformation by what neighbours have done.");
  m.def("carried", &make_carried, "F"_a, "Rotations, and deformations kept within bounds.");
}
