// Words and constants of a snow, from Python to the material table.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>

#include <initializer_list>
#include <map>

#include "bind/choices.hpp"

namespace nb = nanobind;

namespace neve::bind {

template <class E>
E word(const std::string& given, std::initializer_list<std::pair<const char*, E>> words, const char* what) {
  for (const auto& [name, value] : words) {
    if (given == name) return value;
  }
  throw nb::value_error((std::string(what) + " '" + given + "' is not known").c_str());
}

// A row of the material table.
//
// Errors: ValueError for an unknown law, for a word that is no plasticity, and for a constant that no law has.
inline Snow snow_of(const std::string& law, const std::string& plasticity, const Numbers& numbers) {
  Snow snow;
  snow.law = place_of(Laws{}, law, "law");
  snow.plastic = word<bool>(plasticity, {{"snow", true}, {"none", false}}, "plasticity");
  with_law(snow.law, [&](auto found) { snow.set(constants_of<decltype(found)>(numbers)); });
  return snow;
}

}  // namespace neve::bind
