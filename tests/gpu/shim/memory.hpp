// Memory of the stand-in's GPUs. While one GPU works, that of the others cannot be read or written: a kernel that does so
// ends the program.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <map>

namespace shim {

inline constexpr int most_devices = 8;
inline constexpr std::size_t guard = 64, page = 4096;

class Memory {
 public:
  std::size_t limit = std::size_t(1) << 33, used[most_devices] = {}, used_most[most_devices] = {};

  char* allocate(int device, std::size_t size) {
    if (used[device] + size > limit) return nullptr;
    char* at = static_cast<char*>(
        mmap(nullptr, whole(size), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    std::memset(at, 0xff, size);  // NaN: what is read before it is written shows
    std::memset(at + size, 0xa5, guard);
    pieces_[at] = {device, size}, used[device] += size;
    used_most[device] = std::max(used[device], used_most[device]);
    protect(at, pieces_[at]);
    return at;
  }
  void free(char* at) {
    const Piece piece = pieces_.at(at);
    used[piece.device] -= piece.size, pieces_.erase(at), munmap(at, whole(piece.size));
  }
  // Whether the address is in memory of the GPU.
  bool is_of(int device, const void* address) const {
    auto after = pieces_.upper_bound(static_cast<char*>(const_cast<void*>(address)));
    return after != pieces_.begin() && (--after)->second.device == device;
  }
  // Let the memory of one GPU be used, or that of all.
  void open(int device) {
    if (device == open_) return;
    open_ = device;
    for (const auto& [at, piece] : pieces_) protect(at, piece);
  }
  void open_all() { open(all); }
  bool overrun() {
    open_all();
    for (const auto& [at, piece] : pieces_) {
      for (std::size_t k = 0; k < guard; ++k) {
        if (at[piece.size + k] != char(0xa5)) return true;
      }
    }
    return false;
  }

 private:
  static constexpr int all = -1;
  struct Piece {
    int device;
    std::size_t size;
  };
  static std::size_t whole(std::size_t size) { return (size + guard + page - 1) / page * page; }
  void protect(char* at, const Piece& piece) {
    const bool usable = open_ == all || open_ == piece.device;
    mprotect(at, whole(piece.size), usable ? PROT_READ | PROT_WRITE : PROT_NONE);
  }
  std::map<char*, Piece> pieces_;
  int open_ = all;
};

}  // namespace shim
