// A list of types: what there is to choose from. The first is what a scene gets that does not choose.
#pragma once

#include "math/inline.hpp"

namespace neve {

template <class... Items>
struct List {
  static constexpr int size = sizeof...(Items);
};

// f(Item{}) for the item at `place` of the list, counted from 0; the last one for every place beyond it.
template <class First, class... Rest, class F>
NEVE_INLINE constexpr auto pick(List<First, Rest...>, int place, F&& f) {
  if constexpr (sizeof...(Rest) > 0) {
    if (place != 0) return pick(List<Rest...>{}, place - 1, f);
  }
  return f(First{});
}

// The item at `place` of the list, counted from 0.
template <int place, class Items>
struct ItemAt;
template <class First, class... Rest>
struct ItemAt<0, List<First, Rest...>> {
  using type = First;
};
template <int place, class First, class... Rest>
struct ItemAt<place, List<First, Rest...>> {
  using type = typename ItemAt<place - 1, List<Rest...>>::type;
};
template <int place, class Items>
using item_at = typename ItemAt<place, Items>::type;

// f(Item{}) for each item, in the order of the list.
template <class... Items, class F>
constexpr void each(List<Items...>, F&& f) {
  (f(Items{}), ...);
}

// How a choice is called and where it comes from.
struct Word {
  const char* name;     // the word that a scene chooses it by
  const char* meaning;  // one sentence
  const char* source;   // where its equations come from
  const char* cites;    // keys of src/neve/cli/references.bib, with a space between
};

}  // namespace neve
