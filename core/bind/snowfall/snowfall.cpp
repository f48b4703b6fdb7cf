// neve._core.snowfall: where falling snow comes to lie, and what of it slides on.
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bind/arrays.hpp"
#include "snowfall/exposure.hpp"
#include "snowfall/slides.hpp"

namespace neve::bind {

using namespace nb::literals;
using namespace neve::snowfall;

namespace {

using Points = In<double, nb::shape<-1, 3>>;
using Numbers = In<double, nb::shape<-1>>;
using Columns = neve::snowfall::Columns;  // not those of particles

void make_columns(Columns* self, std::array<double, 2> low, double cell, std::array<std::int32_t, 2> cells,
                  const Points& vertices, const In<std::int32_t, nb::shape<-1, 3>>& faces,
                  const In<std::int32_t, nb::shape<-1>>& part, const std::vector<std::string>& kinds) {
  if (part.shape(0) != faces.shape(0)) throw nb::value_error("one part per face");
  std::vector<Point> v(vertices.shape(0));
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = {vertices(i, 0), vertices(i, 1), vertices(i, 2)};
  std::vector<std::array<std::int32_t, 3>> f(faces.shape(0));
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = {faces(i, 0), faces(i, 1), faces(i, 2)};
  std::vector<Part> parts;
  for (const std::string& kind : kinds) {
    if (kind != "closed" && kind != "sheet" && kind != "ground")
      throw nb::value_error("kinds are closed, sheet and ground");
    parts.push_back(kind == "closed" ? Part::closed : kind == "sheet" ? Part::sheet : Part::ground);
  }
  nb::gil_scoped_release release;
  new (self) Columns({low[0], low[1], cell, cells[0], cells[1]}, v, f,
                     {part.data(), part.data() + part.shape(0)}, parts);
}

// A number of each site.
template <class T, class F>
View<T> of_sites(const Columns& columns, F&& f) {
  T* out;
  auto a = fresh<T>(out, {columns.sites().size()});
  for (const Site& site : columns.sites()) *out++ = T(f(site));
  return a;
}

View<double> slope_of(const Columns& columns) {
  double* out;
  auto a = fresh<double>(out, {columns.sites().size(), 2});
  for (const Site& site : columns.sites()) *out++ = site.slope[0], *out++ = site.slope[1];
  return a;
}

void require_sites(const Columns& columns, std::size_t n) {
  if (n != columns.sites().size()) throw nb::value_error("one number per site");
}

// Of each site those along +x, -x, +y, -y that are one surface with it; -1: none.
View<std::int32_t> joined(const Columns& columns, const Numbers& top) {
  require_sites(columns, top.shape(0));
  constexpr int steps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  std::int32_t* out;
  auto a = fresh<std::int32_t>(out, {top.shape(0), 4});
  for (std::uint32_t s = 0; s < top.shape(0); ++s) {
    for (const auto& step : steps) {
      const std::uint32_t to = columns.joined(s, step[0], step[1], top.data());
      *out++ = to == Columns::none ? -1 : std::int32_t(to);
    }
  }
  return a;
}

// Of each site, whether along +x, -x, +y, -y there is a body beside its top, open space, or the rim: 1, 0, 2.
View<std::int8_t> walls(const Columns& columns, const Numbers& top) {
  require_sites(columns, top.shape(0));
  constexpr int steps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  const Raster& raster = columns.raster();
  std::int8_t* out;
  auto a = fresh<std::int8_t>(out, {top.shape(0), 4});
  for (std::uint32_t s = 0; s < top.shape(0); ++s) {
    const auto [i, j] = columns.place(s);
    for (const auto& step : steps) {
      const std::int32_t to_i = i + step[0], to_j = j + step[1];
      if (!raster.holds(to_i, to_j)) {
        *out++ = 2;
        continue;
      }
      const std::size_t c = raster.column(to_i, to_j);
      const bool open = columns.below(c, top(s)) != Columns::none || columns.bottomless(c, top(s));
      *out++ = !open || columns.rises(s, c, top(s), raster.cell);
    }
  }
  return a;
}

nb::tuple exposure(const Columns& columns, const std::vector<const TriangleMesh*>& solids, const Numbers& top,
                   const In<double, nb::shape<-1, 2>>& slope, double flutter, std::array<double, 2> wind,
                   std::uint64_t seed, double tolerance, double detail, std::uint32_t most) {
  require_sites(columns, top.shape(0)), require_sites(columns, slope.shape(0));
  if (!(tolerance > 0 && detail > 0)) throw nb::value_error("tolerance and detail are above zero");
  Exposure found;
  {
    nb::gil_scoped_release release;
    ExposureCount count(columns, solids, {flutter, {wind[0], wind[1]}, seed}, {tolerance, detail, most},
                        {top.data(), slope.data()});
    found = count.run();
  }
  const std::size_t n = found.share.size();
  const std::uint64_t flakes = found.flakes;
  return nb::make_tuple(array(std::move(found.share), {n}), array(std::move(found.error), {n}),
                        array(std::move(found.bucket), {n}), flakes);
}

nb::tuple slide(const Columns& columns, const Numbers& depth, double repose, bool holding_depth,
                double least_slope, double gravity, std::uint32_t passes) {
  require_sites(columns, depth.shape(0));
  std::vector<double> now(depth.data(), depth.data() + depth.shape(0));
  Slid found;
  {
    nb::gil_scoped_release release;
    found = Slides(columns, {repose, holding_depth, least_slope, gravity, passes}, now).run();
  }
  const std::size_t n = now.size();
  nb::dict sums;
  sums["lost"] = found.lost, sums["moved"] = found.moved, sums["over_edges"] = found.over_edges;
  sums["passes"] = found.passes, sums["settled"] = found.settled;
  return nb::make_tuple(array(std::move(now), {n}), sums);
}

}  // namespace

void bind_snowfall(nb::module_& m) {
  nb::class_<Columns>(m, "Columns", "What snow can lie on, over the cells of a square raster.")
      .def("__init__", &make_columns, "low"_a, "cell"_a, "cells"_a, "vertices"_a, "faces"_a, "part"_a,
           "kinds"_a)
      .def("__len__", [](const Columns& c) { return c.sites().size(); })
      .def(
          "column",
          [](const Columns& c) { return of_sites<std::int32_t>(c, [](const Site& s) { return s.column; }); },
          "Over which cell each site is: i ny + j (n,).")
      .def(
          "part",
          [](const Columns& c) { return of_sites<std::int32_t>(c, [](const Site& s) { return s.part; }); },
          "On whose surface each site is (n,).")
      .def(
          "z", [](const Columns& c) { return of_sites<double>(c, [](const Site& s) { return s.z; }); },
          "Height of each site (n,) [m].")
      .def(
          "ceiling",
          [](const Columns& c) { return of_sites<double>(c, [](const Site& s) { return s.ceiling; }); },
          "Height of what hangs above each site (n,) [m]; inf under the sky.")
      .def("slope", &slope_of, "dz/dx and dz/dy of the surface at each site (n, 2) [1], at most 75 degrees.")
      .def("joined", &joined, "top"_a)
      .def("walls", &walls, "top"_a);
  m.def("exposure", &exposure, nb::kw_only(), "columns"_a, "solids"_a, "top"_a, "slope"_a, "flutter"_a,
        "wind"_a, "seed"_a, "tolerance"_a, "detail"_a, "most"_a);
  m.def("slide", &slide, nb::kw_only(), "columns"_a, "depth"_a, "repose"_a, "holding_depth"_a,
        "least_slope"_a, "gravity"_a, "passes"_a);
  m.attr("shortest_piece") = shortest_piece;
  m.attr("piece_growth") = piece_growth;
}

}  // namespace neve::bind
