// neve._core.geometry: bodies of triangles, their signed distance, ground from heights.
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <string>

#include "bind/arrays.hpp"
#include "bind/words.hpp"
#include "geometry/height_field.hpp"
#include "geometry/sdf_build.hpp"
#include "geometry/shapes.hpp"

namespace neve::bind {

using namespace nb::literals;

namespace {

using Points = In<double, nb::shape<-1, 3>>;

Point point(const Points& x, std::size_t i) { return {x(i, 0), x(i, 1), x(i, 2)}; }

// Call f(i) for each point without the lock of Python.
template <class F>
void each_point(const Points& x, F&& f) {
  const std::size_t n = x.shape(0);
  nb::gil_scoped_release release;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 64)
#endif
  for (std::size_t i = 0; i < n; ++i) f(i);
}

template <class F>
auto numbers(const Points& x, F&& f) {
  double* out;
  auto a = fresh<double>(out, {x.shape(0)});
  each_point(x, [&](std::size_t i) { out[i] = f(point(x, i)); });
  return a;
}

// phi (n,) and normals (n, 3) of a solid at points.
template <class S>
nb::tuple sample(const S& solid, const Points& x) {
  const auto view = solid.view();
  double *phi, *normal;
  auto a = fresh<double>(phi, {x.shape(0)});
  auto b = fresh<double>(normal, {x.shape(0), 3});
  each_point(x, [&](std::size_t i) {
    const Surface<double> s = view.at(point(x, i));
    phi[i] = s.phi;
    for (int k = 0; k < 3; ++k) normal[3 * i + std::size_t(k)] = s.normal[k];
  });
  return nb::make_tuple(a, b);
}

View<double> triple(const Vec3<double>& v) {
  double* out;
  auto a = fresh<double>(out, {3});
  out[0] = v.x, out[1] = v.y, out[2] = v.z;
  return a;
}

nb::tuple closest(const TriangleMesh& mesh, const Points& x) {
  double *at, *distance;
  std::int32_t* face;
  auto a = fresh<double>(at, {x.shape(0), 3});
  auto b = fresh<double>(distance, {x.shape(0)});
  auto c = fresh<std::int32_t>(face, {x.shape(0)});
  each_point(x, [&](std::size_t i) {
    const TriangleMesh::Nearest n = mesh.nearest(point(x, i));
    for (int k = 0; k < 3; ++k) at[3 * i + std::size_t(k)] = n.point[k];
    distance[i] = n.distance();
    face[i] = mesh.face(n.triangle);
  });
  return nb::make_tuple(a, b, c);
}

nb::tuple ray(const TriangleMesh& mesh, const Points& origins, const Points& directions) {
  if (origins.shape(0) != directions.shape(0)) throw nb::value_error("one direction per origin");
  double* t;
  std::int32_t* face;
  auto a = fresh<double>(t, {origins.shape(0)});
  auto b = fresh<std::int32_t>(face, {origins.shape(0)});
  each_point(origins, [&](std::size_t i) {
    const TriangleMesh::RayHit hit = mesh.ray(point(origins, i), point(directions, i));
    t[i] = hit.t;
    face[i] = mesh.face(hit.triangle);
  });
  return nb::make_tuple(a, b);
}

TriangleMesh mesh_of(const Points& vertices, const In<std::int32_t, nb::shape<-1, 3>>& faces) {
  std::vector<Point> v(vertices.shape(0));
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = point(vertices, i);
  std::vector<std::array<std::int32_t, 3>> f(faces.shape(0));
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = {faces(i, 0), faces(i, 1), faces(i, 2)};
  return {v, f};
}

void bind_mesh(nb::module_& m) {
  nb::class_<TriangleMesh>(m, "TriangleMesh", "Triangles in their own frame, in a tree of boxes.")
      .def(
          "__init__",
          [](TriangleMesh* self, const Points& vertices, const In<std::int32_t, nb::shape<-1, 3>>& faces) {
            new (self) TriangleMesh(mesh_of(vertices, faces));
          },
          "vertices"_a, "faces"_a)
      .def_prop_ro("triangles", [](const TriangleMesh& s) { return s.triangles().size(); })
      .def_prop_ro("skipped", &TriangleMesh::skipped, "Faces without area, which do not count.")
      .def_prop_ro("closed", &TriangleMesh::closed,
                   "Whether every edge is passed as often one way as the other.")
      .def_prop_ro("inverted", &TriangleMesh::inverted, "Whether the faces looked inwards and were turned.")
      .def_prop_ro("area", &TriangleMesh::area, "[m2]")
      .def_prop_ro("volume", &TriangleMesh::volume, "[m3]; of an open mesh a guess.")
      .def_prop_ro(
          "low", [](const TriangleMesh& s) { return triple(s.bounds().low); }, nb::rv_policy::move)
      .def_prop_ro(
          "high", [](const TriangleMesh& s) { return triple(s.bounds().high); }, nb::rv_policy::move)
      .def(
          "distance",
          [](const TriangleMesh& s, const Points& x) {
            return numbers(x, [&](const Point& p) { return s.nearest(p).distance(); });
          },
          "points"_a, "Distance to the nearest triangle (n,) [m].")
      .def("closest", &closest, "points"_a,
           "(points of the surface (n, 3), their distance (n,) [m], their face (n,)).")
      .def(
          "winding",
          [](const TriangleMesh& s, const Points& x, bool exact) {
            return numbers(x, [&](const Point& p) { return exact ? s.exact_winding(p) : s.winding(p); });
          },
          "points"_a, "exact"_a = false,
          "How often the surface winds around each point (n,): 1 inside, 0 outside. `exact` adds up all "
          "triangles one by one; otherwise far ones count together, within 0.03.")
      .def(
          "signed_distance",
          [](const TriangleMesh& s, const Points& x) {
            return numbers(x, [&](const Point& p) { return s.signed_distance(p); });
          },
          "points"_a, "Distance, negative inside (n,) [m].")
      .def("ray", &ray, "origins"_a, "directions"_a,
           "(t (n,), face (n,)): where rays first meet the surface, in lengths of the direction; inf and -1 "
           "where they do not.");
}

nb::dict arrays(const SdfGrid& s) {
  const auto copy = [](const auto& values, std::initializer_list<std::size_t> shape) {
    std::remove_cvref_t<decltype(values[0])>* out;
    auto a = fresh(out, shape);
    std::copy(values.begin(), values.end(), out);
    return a;
  };
  const auto x = std::size_t(s.bricks[0]), y = std::size_t(s.bricks[1]), z = std::size_t(s.bricks[2]);
  constexpr std::size_t side = SdfGrid::side;
  nb::dict out;
  out["table"] = copy(s.table, {x, y, z});
  out["coarse"] = copy(s.coarse, {x + 1, y + 1, z + 1, 4});
  out["fine"] = copy(s.fine, {s.fine.size() / SdfGrid::brick_floats, side, side, side, 4});
  const std::vector<double> sizes{s.box_low.x, s.box_low.y, s.box_low.z, s.low.x,  s.low.y,
                                  s.low.z,     s.high.x,    s.high.y,    s.high.z, s.spacing,
                                  s.band,      s.thickness, s.openness};
  out["sizes"] = copy(sizes, {sizes.size()});
  return out;
}

SdfGrid from_arrays(const In<std::int32_t, nb::shape<-1, -1, -1>>& table,
                    const In<float, nb::shape<-1, -1, -1, 4>>& coarse,
                    const In<float, nb::shape<-1, SdfGrid::side, SdfGrid::side, SdfGrid::side, 4>>& fine,
                    const In<double, nb::shape<13>>& sizes) {
  SdfGrid s;
  for (std::size_t k = 0; k < 3; ++k) {
    if (table.shape(k) < 1 || table.shape(k) > (1u << 27) || coarse.shape(k) != table.shape(k) + 1)
      throw nb::value_error("table and coarse do not fit each other");
    s.bricks[k] = std::int32_t(table.shape(k));
  }
  s.table.assign(table.data(), table.data() + table.size());
  s.coarse.assign(coarse.data(), coarse.data() + coarse.size());
  s.fine.assign(fine.data(), fine.data() + fine.size());
  for (std::int32_t brick : s.table) {
    if (brick < SdfGrid::coarse_only || brick >= std::int64_t(fine.shape(0)))
      throw nb::value_error("table names a brick that is not there");
  }
  const double* v = sizes.data();
  for (int k = 0; k < 3; ++k) s.box_low[k] = v[k], s.low[k] = v[3 + k], s.high[k] = v[6 + k];
  s.spacing = v[9], s.band = v[10], s.thickness = v[11], s.openness = v[12];
  if (!(s.spacing > 0)) throw nb::value_error("spacing is not above zero");
  return s;
}

// Return one of the arrays that a grid is made of, or say that it is none of the right type and shape.
template <class Array>
Array part(const nb::dict& arrays, const char* name) {
  Array found;
  if (!arrays.contains(name) || !nb::try_cast(arrays[name], found))
    throw nb::value_error((std::string(name) + " is not an array of the type and shape of a grid").c_str());
  return found;
}

void bind_sdf(nb::module_& m) {
  nb::class_<SdfGrid>(m, "SdfGrid", "Signed distance and normal of a body on a sparse grid in its own frame.")
      .def_static(
          "build",
          [](const TriangleMesh& mesh, double spacing, double band, double thickness) {
            nb::gil_scoped_release release;
            return SdfBuilder(mesh, spacing, band, thickness).build();
          },
          "mesh"_a, "spacing"_a, "band"_a, "thickness"_a = 0.0,
          "Sample the distance to the mesh at this spacing [m] wherever it is no more than band [m], more "
          "coarsely elsewhere; with a thickness [m] the distance to a sheet of that thickness.")
      .def_static(
          "bytes_for",
          [](const TriangleMesh& mesh, double spacing, double band, double thickness) {
            nb::gil_scoped_release release;
            return SdfBuilder(mesh, spacing, band, thickness).bytes();
          },
          "mesh"_a, "spacing"_a, "band"_a, "thickness"_a = 0.0, "How large the grid would be [bytes].")
      .def_static(
          "from_arrays",
          [](const nb::dict& d) {
            return from_arrays(part<In<std::int32_t, nb::shape<-1, -1, -1>>>(d, "table"),
                               part<In<float, nb::shape<-1, -1, -1, 4>>>(d, "coarse"),
                               part<In<float, nb::shape<-1, 9, 9, 9, 4>>>(d, "fine"),
                               part<In<double, nb::shape<13>>>(d, "sizes"));
          },
          "arrays"_a, "The grid that `arrays` came from.")
      .def("arrays", &arrays, "All of the grid, as arrays to be saved.")
      .def("sample", &sample<SdfGrid>, "points"_a,
           "(phi (n,) [m], normal (n, 3)) at points in the body's frame.")
      .def_prop_ro("bytes", &SdfGrid::bytes)
      .def_ro("spacing", &SdfGrid::spacing)
      .def_ro("band", &SdfGrid::band)
      .def_ro("thickness", &SdfGrid::thickness)
      .def_ro("openness", &SdfGrid::openness,
              "Of the samples between a spacing and the band (or three spacings) off the surface, the share "
              "whose winding number is more than 0.25 from a whole number: 0 for a closed mesh.")
      .def_prop_ro(
          "low", [](const SdfGrid& s) { return triple(s.low); }, nb::rv_policy::move,
          "Bounds of the body [m].")
      .def_prop_ro("high", [](const SdfGrid& s) { return triple(s.high); }, nb::rv_policy::move);
}

void bind_height_field(nb::module_& m) {
  nb::class_<HeightField>(m, "HeightField", "Ground from heights over a rectangle around the origin.")
      .def(
          "__init__",
          [](HeightField* self, const In<float, nb::shape<-1, -1>>& heights,
             const std::array<double, 2>& size) {
            if (heights.shape(0) > (1u << 20) || heights.shape(1) > (1u << 20))
              throw nb::value_error("heights: at most 2^20 samples a side");
            new (self) HeightField(heights.data(), std::int32_t(heights.shape(0)),
                                   std::int32_t(heights.shape(1)), size[0], size[1]);
          },
          "heights"_a, "size"_a)
      .def("sample", &sample<HeightField>, "points"_a,
           "(phi (n,) [m], normal (n, 3)) at points in the ground's frame.")
      .def_prop_ro(
          "heights",
          [](const HeightField& field) {
            const HeightView& s = field.view();
            float* out;
            auto a = fresh<float>(out, {std::size_t(s.nx), std::size_t(s.ny)});
            for (std::int32_t i = 0; i < s.nx; ++i) {
              for (std::int32_t j = 0; j < s.ny; ++j) *out++ = s.height(i, j);
            }
            return a;
          },
          nb::rv_policy::move)
      .def_prop_ro("size",
                   [](const HeightField& s) { return nb::make_tuple(s.view().size_x, s.view().size_y); })
      .def_prop_ro("low", &HeightField::low, "Least height [m].")
      .def_prop_ro("high", &HeightField::high, "Largest height [m].")
      .def_prop_ro("bytes", &HeightField::bytes);
}

}  // namespace

void bind_geometry(nb::module_& m) {
  m.def(
      "shapes", [] { return tuple_of(shape_names); },
      "Words of all shapes, those with a formula before those with samples.");
  bind_mesh(m);
  bind_sdf(m);
  bind_height_field(m);
}

}  // namespace neve::bind
