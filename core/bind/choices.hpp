// What there is to choose from, for Python: the lists of laws, transfers and splines, with all that they publish.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "constitutive/laws.hpp"
#include "math/bspline.hpp"
#include "transfer/transfers.hpp"

namespace neve::bind {

namespace nb = nanobind;

using Numbers = std::map<std::string, double>;
using Words = std::vector<std::string>;

inline Words split(const char* text) {
  std::istringstream stream(text);
  Words words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// The place of the item called `name`. Errors: ValueError, which says what there is.
template <class... Items>
int place_of(List<Items...> list, const std::string& name, const char* what) {
  int place = 0, found = -1;
  std::string known;
  each(list, [&](auto item) {
    const char* word = decltype(item)::word.name;
    if (name == word) found = place;
    known += (place++ ? ", '" : "'") + std::string(word) + "'";
  });
  if (found < 0) throw nb::value_error((std::string(what) + " '" + name + "' is none of " + known).c_str());
  return found;
}

// Whether any law has a constant of that name.
inline bool is_constant(const std::string& name) {
  bool found = false;
  each(Laws{}, [&](auto law) {
    for (const auto& constant : decltype(law)::constants) found = found || name == constant.name;
  });
  return found;
}

// A law's constants from numbers by name; the usual ones where they are left out, and those of other laws left aside.
template <class Law>
typename Law::Constants constants_of(const Numbers& numbers) {
  typename Law::Constants c{};
  for (const auto& constant : Law::constants) {
    const auto given = numbers.find(constant.name);
    c.*constant.member = given == numbers.end() ? constant.usual : given->second;
  }
  for (const auto& [name, value] : numbers) {
    if (!is_constant(name)) throw nb::value_error(("there is no constant '" + name + "'").c_str());
  }
  if constexpr (requires { Law::complete(c); }) Law::complete(c);
  return c;
}

struct ChoiceInfo {
  std::string name, meaning, source;
  Words cites;

  explicit ChoiceInfo(const Word& word)
      : name(word.name), meaning(word.meaning), source(word.source), cites(split(word.cites)) {}
};

struct ConstantInfo {
  std::string name, unit, source, meaning;
  double usual;
  Range range, drawn;
  Role role;
};

struct LawInfo : ChoiceInfo {
  int place;
  bool has_elastic_option;
  Words plasticity_cites;
  std::string limit;
  std::vector<ConstantInfo> constants;

  template <class Law>
  LawInfo(Law, int place_)
      : ChoiceInfo(Law::word),
        place(place_),
        has_elastic_option(Law::has_elastic_option),
        plasticity_cites(split(Law::plasticity_cites)),
        limit(Law::limit) {
    for (const auto& c : Law::constants)
      constants.push_back({c.name, c.unit, c.source, c.meaning, c.usual, c.range, c.drawn, c.role});
  }

  // f(Law{}, its constants).
  template <class F>
  double of(const Numbers& numbers, F&& f) const {
    return with_law(place, [&](auto law) { return f(law, constants_of<decltype(law)>(numbers)); });
  }
};

struct TransferInfo : ChoiceInfo {
  Words options;
  bool keeps_C, has_change, has_affine_change, damps, has_bounded_energy, separate_position_velocity;

  template <class Transfer>
  explicit TransferInfo(Transfer)
      : ChoiceInfo(Transfer::word),
        options(split(Transfer::options)),
        keeps_C(Transfer::keeps_C),
        has_change(Transfer::has_change),
        has_affine_change(Transfer::has_affine_change),
        damps(Transfer::damps),
        has_bounded_energy(Transfer::has_bounded_energy),
        separate_position_velocity(Transfer::separate_position_velocity) {}
};

inline void bind_constant(nb::module_& m) {
  nb::class_<ConstantInfo>(m, "Constant", "What a law says about one of its constants.")
      .def_ro("name", &ConstantInfo::name)
      .def_ro("usual", &ConstantInfo::usual, "Its default.")
      .def_ro("unit", &ConstantInfo::unit)
      .def_prop_ro(
          "low", [](const ConstantInfo& c) { return c.range.low; }, "Lower end of what is legal.")
      .def_prop_ro(
          "high", [](const ConstantInfo& c) { return c.range.high; }, "Upper end of what is legal.")
      .def_prop_ro(
          "open_low", [](const ConstantInfo& c) { return c.range.open_low; }, "The lower end is not legal.")
      .def_prop_ro(
          "open_high", [](const ConstantInfo& c) { return c.range.open_high; }, "The upper end is not legal.")
      .def_prop_ro(
          "drawn", [](const ConstantInfo& c) { return nb::make_tuple(c.drawn.low, c.drawn.high); },
          "What random trials take.")
      .def_prop_ro(
          "is_plastic", [](const ConstantInfo& c) { return c.role != Role::elastic; },
          "Elasticity alone does not use it.")
      .def_prop_ro(
          "is_threshold", [](const ConstantInfo& c) { return c.role == Role::threshold; },
          "A particle's `strength` multiplies it.")
      .def_ro("source", &ConstantInfo::source)
      .def_ro("meaning", &ConstantInfo::meaning);
}

inline void bind_law(nb::module_& m) {
  nb::class_<LawInfo, ChoiceInfo>(m, "Law", "A constitutive law.")
      .def_ro("constants", &LawInfo::constants)
      .def_ro("has_elastic_option", &LawInfo::has_elastic_option,
              "Whether plasticity = \"none\" leaves its elasticity alone.")
      .def_ro("plasticity_cites", &LawInfo::plasticity_cites, "Papers of its plastic flow.")
      .def_ro("limit", &LawInfo::limit, "Why its thresholds have a limit.")
      .def(
          "most_strength",
          [](const LawInfo& self, const Numbers& constants) {
            return self.of(constants,
                           [](auto law, const auto& c) { return decltype(law)::most_strength(c); });
          },
          nb::arg("constants"), "Largest factor that the thresholds of a snow may have [1].")
      .def(
          "max_compression",
          [](const LawInfo& self, const Numbers& constants, double strongest) {
            return self.of(constants, [&](auto law, const auto& c) {
              return decltype(law)::max_compression(c, strongest);
            });
          },
          nb::arg("constants"), nb::arg("strongest"),
          "How far one step may compress a snow, -dt tr grad v [1]; strongest: the largest factor on its "
          "thresholds.")
      .def(
          "hardening_exponent",
          [](const LawInfo& self, const Numbers& constants) {
            return self.of(constants,
                           [](auto law, const auto& c) { return decltype(law)::hardening_exponent(c); });
          },
          nb::arg("constants"), "Largest exponent of the hardening of a snow [1].");
}

inline void bind_choices(nb::module_& m) {
  nb::class_<ChoiceInfo>(m, "Choice", "One of the words that a scene may choose.")
      .def_ro("name", &ChoiceInfo::name)
      .def_ro("meaning", &ChoiceInfo::meaning)
      .def_ro("source", &ChoiceInfo::source)
      .def_ro("cites", &ChoiceInfo::cites);
  bind_constant(m);
  bind_law(m);
  nb::class_<TransferInfo, ChoiceInfo>(m, "Transfer", "A transfer between particles and grid.")
      .def_ro("options", &TransferInfo::options, "Keys of [numerics] that it reads.")
      .def_ro("keeps_C", &TransferInfo::keeps_C, "The affine velocity travels with the particle.")
      .def_ro("has_change", &TransferInfo::has_change, "Force and momentum stay apart on the grid.")
      .def_ro("has_affine_change", &TransferInfo::has_affine_change, "C changes by what changed on the grid.")
      .def_ro("damps", &TransferInfo::damps, "All motions but translations fade.")
      .def_ro("has_bounded_energy", &TransferInfo::has_bounded_energy,
              "No step gives the particles more than the grid had.")
      .def_ro("separate_position_velocity", &TransferInfo::separate_position_velocity,
              "Particles move with a velocity other than their own.");
  m.def(
      "laws",
      [] {
        std::vector<LawInfo> found;
        each(Laws{}, [&](auto law) { found.emplace_back(law, static_cast<int>(found.size())); });
        return found;
      },
      "The constitutive laws, the default first.");
  m.def(
      "transfers",
      [] {
        std::vector<TransferInfo> found;
        each(Transfers{}, [&](auto transfer) { found.emplace_back(transfer); });
        return found;
      },
      "The transfers, the default first.");
  m.def(
      "splines",
      [] {
        std::vector<ChoiceInfo> found;
        each(Splines{}, [&](auto spline) { found.emplace_back(decltype(spline)::word); });
        return found;
      },
      "The splines, the default first.");
}

}  // namespace neve::bind
