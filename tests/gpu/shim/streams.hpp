// Streams of the stand-in: work in order, that waits for marks in other streams. What nobody waits for yet may be done as
// late as possible: if a result depends on when, something does not wait that must.
#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "memory.hpp"

namespace shim {

struct Launch {
  void* function;
  unsigned blocks, threads;
  std::vector<char> step;
};
using Graph = std::vector<Launch>;

enum class Late { none, lanes, usual };  // which streams work as late as possible
inline Late late = Late::none;
inline Memory memory;

struct Stream {
  int device = 0;
  bool is_usual = false, captures = false;
  Graph graph;  // what it has captured
  std::deque<std::function<void()>> work;
  std::size_t issued = 0, done = 0;

  void add(std::function<void()> what) {
    work.push_back(std::move(what)), ++issued;
    const bool waits = is_usual ? late == Late::usual : late == Late::lanes;
    if (!waits) run(issued);
  }
  void run(std::size_t until) {
    while (done < until) {
      const auto what = std::move(work.front());
      work.pop_front();
      memory.open(device);
      what();
      ++done;
    }
  }
  void finish() { run(issued); }
};

struct Event {
  Stream* stream = nullptr;
  std::size_t after = 0;
};

inline std::vector<Stream*> lanes;
inline Stream usual[most_devices];

inline void finish_all() {
  for (Stream& each : usual) each.finish();
  for (Stream* each : lanes) each->finish();
}

}  // namespace shim
