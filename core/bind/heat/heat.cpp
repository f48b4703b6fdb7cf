// neve._core.heat: what layers of lying snow share with particles.
#include "bind/arrays.hpp"
#include "heat/sintering.hpp"

namespace neve::bind {

using namespace nb::literals;

namespace {

using Layers = In<double, nb::shape<-1, -1>>;

View<double> conductivity(const Layers& density) {
  double* out;
  auto a = fresh<double>(out, {density.shape(0), density.shape(1)});
  for (std::size_t i = 0; i < density.size(); ++i) out[i] = heat::k_snow(density.data()[i]);
  return a;
}

View<double> grown(const Layers& growth, const Layers& density, const Layers& celsius, double dt) {
  if (density.size() != growth.size() || celsius.size() != growth.size())
    throw nb::value_error("growth, density and celsius have a number for each layer");
  double* out;
  auto a = fresh<double>(out, {growth.shape(0), growth.shape(1)});
  for (std::size_t i = 0; i < growth.size(); ++i) {
    const double most = sintering::strength_of_ice(density.data()[i]);
    out[i] = sintering::grown(std::max(growth.data()[i], 1.0), 1.0, most, celsius.data()[i], dt);
  }
  return a;
}

}  // namespace

void bind_heat_laws(nb::module_& m) {
  m.attr("latent") = heat::latent, m.attr("c_ice") = heat::c_ice, m.attr("c_water") = heat::c_water;
  m.attr("strength_power") = sintering::of_density;
  m.def("conductivity", &conductivity, "density"_a);
  m.def("grown", &grown, "growth"_a, "density"_a, "celsius"_a, "dt"_a);
}

}  // namespace neve::bind
