// Words and constants of a snow, from Python to the material table.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <initializer_list>
#include <map>

#include "constitutive/law.hpp"

namespace nb = nanobind;

namespace neve::bind {

template <class E>
E word(const std::string& given, std::initializer_list<std::pair<const char*, E>> words, const char* what) {
  for (const auto& [name, value] : words) {
    if (given == name) return value;
  }
  throw nb::value_error((std::string(what) + " '" + given + "' is not known").c_str());
}

using Constants = std::map<std::string, double>;

// A row of the material table; a constant that is left out is zero, an unknown one is an error.
inline Snow snow_of(const std::string& law, const std::string& plasticity, const Constants& constants) {
  static const std::map<std::string, double Snow::*> members = {
      {"E0", &Snow::E0},
      {"nu", &Snow::nu},
      {"rho0", &Snow::rho0},
      {"xi", &Snow::xi},
      {"theta_c", &Snow::theta_c},
      {"theta_s", &Snow::theta_s},
      {"J_P_min", &Snow::J_P_min},
      {"J_P_max", &Snow::J_P_max},
      {"cohesion", &Snow::cohesion},
      {"friction_angle", &Snow::friction_angle},
      {"M", &Snow::M},
      {"beta", &Snow::beta},
      {"p0", &Snow::p0},
  };
  Snow snow;
  snow.law = word<LawName>(law,
                           {{"stomakhin2013", LawName::stomakhin2013},
                            {"neo_hookean", LawName::neo_hookean},
                            {"hencky", LawName::hencky},
                            {"drucker_prager", LawName::drucker_prager},
                            {"cam_clay", LawName::cam_clay}},
                           "law");
  snow.plastic = word<bool>(plasticity, {{"snow", true}, {"none", false}}, "plasticity");
  for (const auto& [name, value] : constants) {
    const auto found = members.find(name);
    if (found == members.end()) throw nb::value_error(("there is no constant '" + name + "'").c_str());
    snow.*(found->second) = value;
  }
  snow.sine = std::sin(snow.friction_angle * (3.14159265358979323846 / 180));
  return snow;
}

}  // namespace neve::bind
