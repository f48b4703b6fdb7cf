// Words of an enumeration, from Python and to Python.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <string>

namespace nb = nanobind;

namespace neve::bind {

// The value that a word names; `names` has one for each, in order. Errors: ValueError that lists them.
template <class E, std::size_t N>
E value_of(const std::string& word, const char* const (&names)[N], const char* what) {
  std::string all;
  for (std::size_t k = 0; k < N; ++k) {
    if (word == names[k]) return E(k);
    all += std::string(k == 0 ? "" : ", ") + names[k];
  }
  throw nb::value_error((std::string(what) + " '" + word + "' is not one of " + all).c_str());
}

template <std::size_t N>
nb::tuple tuple_of(const char* const (&names)[N]) {
  nb::list all;
  for (const char* name : names) all.append(name);
  return nb::tuple(all);
}

}  // namespace neve::bind
