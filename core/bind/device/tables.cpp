// A model as a GPU needs it: its tables as bytes, with the addresses of arrays that lie there.
#include "bind/device/tables.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include <vector>

#include "coupling/body_solver.hpp"
#include "cuda/grid/views.hpp"
#include "mpm/dispatch.hpp"

namespace neve::bind {

namespace nb = nanobind;

template <class E>
nb::bytes bytes_of(const E* first, std::size_t count) {
  return nb::bytes(reinterpret_cast<const char*>(first), count * sizeof(E));
}

// The arrays of samples that a view points to, in the order in which with_addresses() takes their new places.
inline nb::list samples_of(const SdfView& view) {
  std::size_t bricks = 1, corners = 1;
  for (int k = 0; k < 3; ++k)
    bricks *= std::size_t(view.bricks[k]), corners *= std::size_t(view.bricks[k]) + 1;
  std::size_t fine = 0;
  for (std::size_t b = 0; b < bricks; ++b) fine += view.table[b] != SdfView::coarse_only;
  nb::list out;
  out.append(bytes_of(view.table, bricks));
  out.append(bytes_of(view.coarse, 4 * corners));
  out.append(bytes_of(view.fine, fine * SdfView::brick_floats));
  return out;
}
inline nb::list samples_of(const HeightView& view) {
  nb::list out;
  out.append(bytes_of(view.quads, 4 * std::size_t(view.nx) * std::size_t(view.ny)));
  out.append(bytes_of(view.tops, std::size_t(view.tiles_x) * std::size_t(view.tiles_y)));
  return out;
}
template <class E>
const E* pointer(std::uint64_t address) {
  return reinterpret_cast<const E*>(static_cast<std::uintptr_t>(address));
}
inline SdfView with_addresses(SdfView view, const std::vector<std::uint64_t>& at) {
  view.table = pointer<std::int32_t>(at.at(0));
  view.coarse = pointer<float>(at.at(1)), view.fine = pointer<float>(at.at(2));
  return view;
}
inline HeightView with_addresses(HeightView view, const std::vector<std::uint64_t>& at) {
  view.quads = pointer<float>(at.at(0)), view.tops = pointer<float>(at.at(1));
  return view;
}

// f(view) for the samples of a solid, if it has any.
template <class T, class F>
void with_view(const Solid<T>& solid, F&& f) {
  if (solid.mesh) f(*solid.mesh);
  if (solid.terrain) f(*solid.terrain);
}

template <class T>
void bind_device_solids(nb::class_<Model<T>>& c) {
  using M = Model<T>;
  c.def(
       "device_samples",
       [](const M& self, std::size_t i) {
         nb::list out;
         with_view(self.solids.at(i), [&](const auto& view) { out = samples_of(view); });
         return out;
       },
       nb::arg("index"), "The arrays of samples of a solid, as bytes; none for shapes with a formula.")
      .def(
          "device_view",
          [](const M& self, std::size_t i, const std::vector<std::uint64_t>& addresses) {
            nb::bytes out("", 0);
            with_view(self.solids.at(i), [&](const auto& view) {
              const auto moved = with_addresses(view, addresses);
              out = bytes_of(&moved, 1);
            });
            return out;
          },
          nb::arg("index"), nb::arg("addresses"),
          "What a solid's shape is to a device that has its samples at these addresses.")
      .def(
          "device_solids",
          [](const M& self, const std::vector<std::uint64_t>& views) {
            std::vector<Solid<T>> moved = self.solids;
            for (std::size_t i = 0; i < moved.size(); ++i) {
              if (moved[i].mesh) moved[i].mesh = pointer<SdfView>(views.at(i));
              if (moved[i].terrain) moved[i].terrain = pointer<HeightView>(views.at(i));
            }
            return bytes_of(moved.data(), moved.size());
          },
          nb::arg("views"), "The solids where they are now, with their views at these addresses.");
}

// (n, 6): velocities and angular velocities of bodies.
inline nb::ndarray<nb::numpy, double> array_of(const std::vector<Twist>& U) {
  auto* kept = new std::vector<Twist>(U);
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<Twist>*>(p); });
  return nb::ndarray<nb::numpy, double>(reinterpret_cast<double*>(kept->data()), {U.size(), 6}, owner);
}

// The responses of n bodies, as somebody else has summed them.
using ResponseArray = nb::ndarray<const double, nb::shape<-1, 42>, nb::c_contig, nb::device::cpu>;
inline std::vector<BodyResponse> responses_of(const ResponseArray& a, std::size_t n) {
  if (a.shape(0) != n) throw nb::value_error("a response of 42 numbers is needed for each body");
  std::vector<BodyResponse> out(n);
  static_assert(sizeof(BodyResponse) == 42 * sizeof(double));
  std::memcpy(out.data(), a.data(), n * sizeof(BodyResponse));
  return out;
}

template <class T>
void bind_device_bodies(nb::class_<Model<T>>& c) {
  using M = Model<T>;
  c.def_prop_ro("body_count", [](const M& self) { return self.bodies.solids.size(); })
      .def(
          "solve_bodies",
          [](M& self, double dt, const nb::callable& response) {
            const auto respond = [&](const std::vector<Twist>& now) {
              return responses_of(nb::cast<ResponseArray>(response(array_of(now))), now.size());
            };
            const auto U = BodyVelocitySolver(self.bodies, dt).solve(whole_responses(respond));
            set_velocities(self.bodies, U, self.solids);
            return array_of(U);
          },
          nb::arg("dt"), nb::arg("response"),
          "Find the velocities of the bodies after dt, (b, 6), and let them move so. response(U): what the "
          "snow does to bodies that move with U, (b, 42).");
}

template <class T>
void bind_device(nb::module_& m, nb::class_<Model<T>>& c) {
  using M = Model<T>;
  m.attr("device_step_bytes") = sizeof(cuda::Step<T>);
  m.attr("device_control_bytes") = sizeof(cuda::Control<T>);
  c.def_prop_ro(
       "device_choice",
       [](const M& self) {
         unsigned laws = 0;
         for (const Snow& snow : self.snows) laws |= 1u << snow.law;
         return nb::make_tuple(self.spline, self.transfer, self.polypic_modes, laws, !self.solids.empty(),
                               has_play(self));
       },
       "Places of spline and transfer in their lists, modes, a bit for each law, whether there are solids, "
       "and "
       "some with play.")
      .def(
          "device_constants",
          [](const M& self, double dt) {
            return with_spline(self.spline, [&](auto spline) {
              const auto step = StepConstants<T>::template of<decltype(spline)>(self.dx, dt, self.alpha(dt));
              const cuda::Constants<T> out{step, self.gravity};
              return bytes_of(&out, 1);
            });
          },
          nb::arg("dt"), "The constants of a step of dt [s], as bytes.")
      .def_prop_ro(
          "device_blend",
          [](const M& self) { return nb::make_tuple(self.flip_alpha, self.flip_damping.value_or(-1)); })
      .def_prop_ro("keeps_change", &keeps_change<T>, "Whether the grid keeps changes of velocity.")
      .def_prop_ro("snow_count", [](const M& self) { return self.snows.size(); })
      .def_prop_ro("solid_count", [](const M& self) { return self.solids.size(); })
      .def_prop_ro(
          "device_snows", [](const M& self) { return bytes_of(self.snows.data(), self.snows.size()); },
          "The material table, as bytes.");
  bind_device_solids<T>(c);
  bind_device_bodies<T>(c);
}

template void bind_device(nb::module_&, nb::class_<Model<float>>&);
template void bind_device(nb::module_&, nb::class_<Model<double>>&);

}  // namespace neve::bind
