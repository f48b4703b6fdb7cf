// In which order homes give to nodes that they share, on several threads.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "cpu/grid/blocks.hpp"
#include "threads.hpp"

namespace neve {

// A node gets its sums in the order of the homes' colours, whatever the threads do. Not all homes of a colour need be done
// before the next: of columns along z whose parities of x and y are the same, each goes up by itself, a home of odd z after the
// even ones below and above it, so that its nodes stay in the cache. Columns are cut into pieces; an odd home between two pieces
// waits for both. On several ranks the turn of a colour has its homes alone, since what other ranks give comes in between.
class Turns {
 public:
  // Homes by rising key, or two such rows one after the other; each colour `apart`, or in columns.
  void lay_out(const std::vector<Home>& homes, bool apart) {
    apart_ = apart;
    for (Turn& turn : turns_) turn.homes.clear(), turn.ends.clear();
    std::vector<std::int32_t> rising(homes.size());
    for (std::size_t h = 0; h < homes.size(); ++h) rising[h] = static_cast<std::int32_t>(h);
    const auto less = [&](std::int32_t a, std::int32_t b) {
      return key_of(homes[std::size_t(a)].at) < key_of(homes[std::size_t(b)].at);
    };
    if (!std::is_sorted(rising.begin(), rising.end(), less)) std::sort(rising.begin(), rising.end(), less);
    const std::size_t longest =
        std::clamp<std::size_t>(homes.size() / (32 * std::size_t(thread_count())), 2, 32);
    for (std::size_t first = 0, end = 0; first < rising.size(); first = end) {
      const BlockCoord at = homes[std::size_t(rising[first])].at;
      while (end < rising.size() && in_column(homes[std::size_t(rising[end])].at, at)) ++end;
      if (apart)
        add_apart(homes, rising.data() + first, rising.data() + end);
      else
        add_column(homes, rising.data() + first, rising.data() + end, longest);
    }
  }

  // Call f(home, the home after it) for each home of `homes`, in parallel, in their turns. At the start of each turn each
  // thread calls `first(turn)`, which may do what f does for other homes of the colour.
  template <class F, class First>
  void each(const std::vector<Home>& homes, F&& f, First&& first) const {
    std::vector<Shares> shares;
    for (const Turn& turn : turns_) shares.emplace_back(turn.ends.size());
#if defined(_OPENMP)
#pragma omp parallel
#endif
    for (std::size_t t = 0; t < turns_.size(); ++t) {
      const Turn& turn = turns_[t];
      first(t);
      shares[t].work([&](std::size_t piece) {
        for (std::size_t k = piece ? turn.ends[piece - 1] : 0; k < turn.ends[piece]; ++k) {
          const std::size_t after = std::min(k + 1, turn.homes.size() - 1);
          f(homes[std::size_t(turn.homes[k])], homes[std::size_t(turn.homes[after])]);
        }
      });
#if defined(_OPENMP)
      if ((apart_ || !turn.ends.empty()) && t + 1 < turns_.size()) {
#pragma omp barrier
      }
#endif
    }
  }
  template <class F>
  void each(const std::vector<Home>& homes, F&& f) const {
    each(homes, f, [](std::size_t) {});
  }

 private:
  struct Turn {
    std::vector<std::int32_t> homes;
    std::vector<std::uint32_t> ends;  // of pieces
    void end_piece() {
      if (homes.size() > (ends.empty() ? 0 : ends.back())) ends.push_back(std::uint32_t(homes.size()));
    }
  };

  static bool in_column(BlockCoord a, BlockCoord b) { return a.x == b.x && a.y == b.y; }

  // Add the homes of a column each by itself, to the turns of their colours.
  void add_apart(const std::vector<Home>& homes, const std::int32_t* first, const std::int32_t* end) {
    for (const std::int32_t* h = first; h < end; ++h) {
      Turn& turn = turns_[std::size_t(colour_of(homes[std::size_t(*h)].at))];
      turn.homes.push_back(*h), turn.end_piece();
    }
  }

  // Add the homes of a column, by rising z.
  void add_column(const std::vector<Home>& homes, const std::int32_t* first, const std::int32_t* end,
                  std::size_t longest) {
    const BlockCoord at = homes[std::size_t(*first)].at;
    const auto pair = std::size_t(colour_of({at.x, at.y, 0}));
    Turn &pieces = turns_[pair], &between = turns_[pair + 1];
    const auto touch = [&](const std::int32_t* a, const std::int32_t* b) {
      return homes[std::size_t(*a)].at.z + 1 == homes[std::size_t(*b)].at.z;
    };
    std::size_t length = 0;  // of the piece
    const auto add = [&](const std::int32_t* h) { pieces.homes.push_back(*h), ++length; };
    const auto cut = [&] { pieces.end_piece(), length = 0; };
    const std::int32_t* waiting = nullptr;  // an odd one, for the even one above it
    for (const std::int32_t* h = first; h < end; ++h) {
      const bool below = h > first && touch(h - 1, h), above = h + 1 < end && touch(h, h + 1);
      const bool odd = homes[std::size_t(*h)].at.z & 1;
      const bool full = length >= longest && (odd ? above : !below);
      if (full) cut();
      if (odd && above && full && below) {
        between.homes.push_back(*h), between.end_piece();
      } else if (odd && above) {
        waiting = h;
      } else {
        add(h);
        if (waiting) add(waiting), waiting = nullptr;
      }
    }
    cut();
  }

  std::array<Turn, 8> turns_;  // of each pair of parities, pieces of columns, then what lies between them
  bool apart_ = false;         // turns are colours
};

}  // namespace neve
