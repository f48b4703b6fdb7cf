// neve._core: the compiled core.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bind/choices.hpp"
#include "cpu/heat/pass.hpp"
#include "cpu/passes/totals.hpp"
#include "mpm/step_choice.hpp"

namespace nb = nanobind;

namespace neve::bind {
void bind_f32(nb::module_& m);
void bind_f64(nb::module_& m);
void bind_geometry(nb::module_& m);
void bind_heat_laws(nb::module_& m);
void bind_implicit(nb::module_& f32, nb::module_& f64);
void bind_ranks(nb::module_& f32, nb::module_& f64);
void bind_rigid(nb::module_& m);
void bind_particles(nb::module_& m, nb::module_& f32, nb::module_& f64);
void bind_snowfall(nb::module_& m);
void bind_sph(nb::module_& m, nb::module_& f32, nb::module_& f64);
}  // namespace neve::bind

namespace {

constexpr int most_threads = 1024;

const char* simd_name() {
#if defined(__AVX512F__)
  return "avx512";
#elif defined(__AVX2__)
  return "avx2";
#elif defined(__AVX__)
  return "avx";
#elif defined(__SSE2__)
  return "sse2";
#elif defined(__ARM_NEON)
  return "neon";
#else
  return "none";
#endif
}

// The level of x86-64 that this build needs, by what the compiler may use.
const char* isa_name() {
#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512CD__) && defined(__AVX512DQ__) && \
    defined(__AVX512VL__)
  return "x86-64-v4";
#elif defined(__AVX2__) && defined(__FMA__)
  return "x86-64-v3";
#elif defined(__SSE4_2__)
  return "x86-64-v2";
#elif defined(__x86_64__)
  return "x86-64";
#elif defined(__aarch64__)
  return "armv8-a";
#else
  return "none";
#endif
}

nb::dict build_info() {
  nb::dict info;
  info["isa"] = isa_name();
  info["simd"] = simd_name();
  info["lanes_f32"] = neve::lane_count<float>;
  info["lanes_f64"] = neve::lane_count<double>;
#if defined(__clang__)
  info["compiler"] = "clang " __clang_version__;
#else
  info["compiler"] = "gcc " __VERSION__;
#endif
#if defined(_OPENMP)
  info["openmp"] = true;
#else
  info["openmp"] = false;
#endif
  info["threads"] = neve::thread_count();
  return info;
}

void bind_totals(nb::module_& m) {
  nb::class_<neve::Totals>(m, "Totals", "Sums over all particles, in double.")
      .def_ro("mass", &neve::Totals::mass)
      .def_prop_ro("momentum",
                   [](const neve::Totals& t) {
                     return std::array<double, 3>{t.momentum[0], t.momentum[1], t.momentum[2]};
                   })
      .def_ro("kinetic", &neve::Totals::kinetic)
      .def_ro("affine", &neve::Totals::affine)
      .def_ro("elastic", &neve::Totals::elastic)
      .def_ro("potential", &neve::Totals::potential)
      .def_ro("heat", &neve::Totals::heat)
      .def_ro("water", &neve::Totals::water);
}

void bind_heat(nb::module_& m) {
  using neve::HeatModel, neve::HeatReport, neve::GridHeatReport;
  nb::class_<HeatModel>(m, "HeatModel", "What a scene says of heat.")
      .def(
          "__init__",
          [](HeatModel* self, double air, double exchange, double sun, std::array<double, 3> towards,
             double conductivity, double speed, bool sinters) {
            new (self) HeatModel{air, exchange, sun, towards, conductivity, speed, sinters};
          },
          nb::kw_only(), nb::arg("air"), nb::arg("exchange"), nb::arg("sun"), nb::arg("towards"),
          nb::arg("conductivity"), nb::arg("speed"), nb::arg("sinters"));
  nb::class_<HeatReport>(m, "HeatReport", "What a pass over the heat found.")
      .def_ro("taken", &HeatReport::taken)
      .def_ro("rounds", &HeatReport::rounds)
      .def_ro("endless", &HeatReport::endless)
      .def_ro("finite", &HeatReport::finite);
  nb::class_<GridHeatReport, HeatReport>(m, "GridHeatReport", "The same, and what the particles make of it.")
      .def_prop_ro("changed", [](const GridHeatReport& r) { return r.changed; })
      .def_prop_ro("woken", [](const GridHeatReport& r) { return r.woken; });
}

void bind_step_choice(nb::module_& m) {
  using neve::StepLimits, neve::ParticleRates;
  nb::class_<StepLimits>(m, "StepLimits", "What the scene and its snow allow a step.")
      .def(
          "__init__",
          [](StepLimits* self, double dx, double cfl, double courant, double strain_max, double dt_max,
             double dt, double max_compression, double solid_speed) {
            new (self) StepLimits{dx, cfl, courant, strain_max, dt_max, dt, max_compression, solid_speed};
          },
          nb::kw_only(), nb::arg("dx"), nb::arg("cfl"), nb::arg("courant"), nb::arg("strain_max"),
          nb::arg("dt_max"), nb::arg("dt"), nb::arg("max_compression"), nb::arg("solid_speed"))
      .def_ro("dx", &StepLimits::dx)
      .def_ro("cfl", &StepLimits::cfl)
      .def_ro("courant", &StepLimits::courant)
      .def_ro("strain_max", &StepLimits::strain_max)
      .def_ro("dt_max", &StepLimits::dt_max)
      .def_ro("dt", &StepLimits::dt)
      .def_ro("max_compression", &StepLimits::max_compression)
      .def_ro("solid_speed", &StepLimits::solid_speed)
      .def_prop_ro("largest_strain", &StepLimits::largest_strain);
  nb::class_<ParticleRates>(m, "ParticleRates", "What a step follows from.")
      .def(
          "__init__",
          [](ParticleRates* self, double wave, double speed, double fastest, double strain_rate,
             double compression_rate, double ice_room) {
            new (self) ParticleRates{wave, speed, fastest, strain_rate, compression_rate, ice_room};
          },
          nb::arg("wave"), nb::arg("speed"), nb::arg("fastest"), nb::arg("strain_rate"),
          nb::arg("compression_rate"), nb::arg("ice_room"));
  const auto named = [](neve::StepChoice choice) {
    return nb::make_tuple(choice.dt, neve::step_bounds[int(choice.bound)]);
  };
  m.def("stable_step", &neve::stable_step, nb::arg("limits"), nb::arg("rates"));
  m.def("fitted", &neve::fitted, nb::arg("dt"), nb::arg("remaining"));
  m.def(
      "longest_stable",
      [named](const StepLimits& limits, const ParticleRates& rates) {
        return named(neve::longest_stable(limits, rates));
      },
      nb::arg("limits"), nb::arg("rates"));
  m.def(
      "largest_step",
      [named](const StepLimits& limits, const ParticleRates& rates) {
        return named(neve::largest_step(limits, rates));
      },
      nb::arg("limits"), nb::arg("rates"));
  m.def(
      "needs_trial",
      [](const StepLimits& limits, double speed, double difference, double change, bool finite,
         const ParticleRates& before,
         double dt) { return neve::needs_trial(limits, {speed, difference, change, finite}, before, dt); },
      nb::arg("limits"), nb::arg("speed"), nb::arg("difference"), nb::arg("change"), nb::arg("finite"),
      nb::arg("before"), nb::arg("dt"));
  m.attr("shortest_share") = neve::shortest_share;
  m.attr("step_bounds") =
      nb::cast(std::vector<std::string>(std::begin(neve::step_bounds), std::end(neve::step_bounds)));
}

}  // namespace

NB_MODULE(_core, m) {
  nb::set_leak_warnings(false);  // what lives until the interpreter ends is no news for who runs a command
  m.doc() = "Neve's compiled core: the stages of the material point method in float32 and float64.";
  m.def("build_info", &build_info, "Compiler, instruction set, lanes and threads of this build.");
  m.def(
      "set_threads",
      [](int n) {
        if (n < 1 || n > most_threads) throw nb::value_error("n: a number of threads from 1 to 1024");
        neve::set_thread_count(n);
      },
      nb::arg("n"), "Use n threads from now on.");
  m.def("threads", &neve::thread_count, "Threads in use.");
  nb::class_<neve::Report>(m, "Report", "What a pass over the particles found.")
      .def_ro("wave", &neve::Report::wave, "Largest elastic wave speed [m/s].")
      .def_ro("speed", &neve::Report::speed, "Largest particle speed [m/s].")
      .def_ro("fastest", &neve::Report::fastest, "Largest sum of both on one particle [m/s].")
      .def_ro("strain_rate", &neve::Report::strain_rate, "Largest |grad v| [1/s].")
      .def_ro("compression_rate", &neve::Report::compression_rate, "Largest -tr grad v [1/s].")
      .def_ro("max_displacement", &neve::Report::max_displacement,
              "Longest way of a particle in the step [cells].")
      .def_ro("min_volume_ratio", &neve::Report::min_volume_ratio, "Smallest det(I + dt grad v).")
      .def_ro("ice_room", &neve::Report::ice_room, "Smallest J over that of ice [1].")
      .def_ro("finite", &neve::Report::finite)
      .def_ro("drifted", &neve::Report::drifted)
      .def_ro("offending_id", &neve::Report::offending_id,
              "Lowest birth number among the particles that make the step unacceptable.")
      .def("merge", &neve::Report::merge, nb::arg("other"))
      .def_prop_ro("rejected", &neve::Report::rejected, "The step must not be taken.");
  nb::class_<neve::GridReport>(m, "GridReport", "What the nodes' velocities would do to the particles.")
      .def_ro("speed", &neve::GridReport::speed, "Largest speed of a node [m/s].")
      .def_ro("max_velocity_difference", &neve::GridReport::max_velocity_difference,
              "Largest difference of velocities around a home [m/s].")
      .def_ro("max_velocity_change", &neve::GridReport::max_velocity_change,
              "Largest change of velocity in the step, if it is kept [m/s].")
      .def_ro("finite", &neve::GridReport::finite);
  bind_heat(m);
  bind_step_choice(m);
  m.attr("ice_density") = neve::ice_density;
  m.attr("displacement_limit") = neve::displacement_limit;
  m.attr("volume_ratio_limit") = neve::volume_ratio_limit;
  bind_totals(m);
  neve::bind::bind_choices(m);
  auto geometry =
      m.def_submodule("geometry", "Bodies of triangles, their signed distance, ground from heights.");
  neve::bind::bind_geometry(geometry);
  auto heat = m.def_submodule("heat", "Laws of heat and sintering, for layers.");
  neve::bind::bind_heat_laws(heat);
  auto snowfall = m.def_submodule("snowfall", "Where falling snow comes to lie.");
  neve::bind::bind_snowfall(snowfall);
  neve::bind::bind_rigid(m);
  auto f32 = m.def_submodule("f32", "Single precision.");
  neve::bind::bind_f32(f32);
  auto f64 = m.def_submodule("f64", "Double precision, for verification and wide worlds.");
  neve::bind::bind_f64(f64);
  neve::bind::bind_implicit(f32, f64);
  neve::bind::bind_ranks(f32, f64);
  neve::bind::bind_particles(m, f32, f64);
  neve::bind::bind_sph(m, f32, f64);
}
