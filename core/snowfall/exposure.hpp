// How much of the falling snow reaches each site: flakes counted in buckets, refined where the count differs.
#pragma once

#include <utility>

#include "snowfall/columns.hpp"
#include "snowfall/flakes.hpp"
#include "threads.hpp"

namespace neve::snowfall {

struct Counting {
  double tolerance;    // standard error of a bucket's exposure at which it has enough flakes [1]
  double detail;       // difference of the exposures of its parts from which a bucket is split [1]
  std::uint32_t most;  // flakes of a bucket
};

// Where sites are now: heights of the top of their snow, and its slope.
struct Tops {
  const double* z;      // (sites,) [m]
  const double* slope;  // (sites, 2) [1]
};

struct Exposure {
  std::vector<double> share;  // of what falls on level open ground, per area seen from above (sites,) [1]
  std::vector<double> error;  // its standard error (sites,) [1]
  std::vector<std::uint32_t> bucket;  // edge of the bucket that a site is in (sites,) [cells]
  std::uint64_t flakes = 0;           // that were followed
};

namespace detail {

struct Tally {
  std::uint32_t flakes = 0, arrived = 0;
  double sum = 0, squares = 0;

  void add(double weight) {
    ++flakes, arrived += weight > 0;
    sum += weight, squares += weight * weight;
  }
  void add(const Tally& o) {
    flakes += o.flakes, arrived += o.arrived;
    sum += o.sum, squares += o.squares;
  }
  double mean() const { return flakes > 0 ? sum / flakes : 0.0; }
  // Variance of the mean. Where all flakes arrived, or none, that of one more of the other kind (Laplace's rule):
  // a few flakes alike prove little.
  double variance() const {
    const double n = flakes, p = (arrived + 1.0) / (n + 2.0), size = arrived > 0 ? sum / arrived : 1.0;
    const double seen = squares / n - mean() * mean();
    return std::fmax(seen, p * (1 - p) * size * size) / n;
  }
};

// Sites of one surface over a square of cells, a quarter after the other.
struct Bucket {
  std::uint32_t quarter[5];  // where its quarters begin in the order of sites, and where the last ends
  std::int32_t i, j;         // its least cell
  std::uint32_t edge;        // [cells]
  Tally tally[4];
  std::uint32_t first() const { return quarter[0]; }
  std::uint32_t last() const { return quarter[4]; }
  Tally all() const {
    Tally sum;
    for (const Tally& t : tally) sum.add(t);
    return sum;
  }
};

}  // namespace detail

class ExposureCount {
 public:
  static constexpr std::uint32_t largest = 8;  // edge of the first buckets [cells]
  static constexpr std::uint32_t batch = 64;   // flakes of a bucket in one round

  ExposureCount(const Columns& columns, const std::vector<const TriangleMesh*>& solids,
                const Weather& weather, const Counting& counting, const Tops& tops)
      : columns_(columns), solids_(solids), weather_(weather), counting_(counting), tops_(tops) {
    for (const TriangleMesh* solid : solids) top_ = std::fmax(top_, solid->bounds().high.z);
  }

  Exposure run() {
    using detail::Bucket;
    const std::size_t n = columns_.sites().size();
    Exposure out;
    out.share.assign(n, 0.0), out.error.assign(n, 0.0), out.bucket.assign(n, 1);
    of_site_.assign(n, {});
    std::vector<Bucket> active = first_buckets(), next;
    while (!active.empty()) {
      each_index(active.size(), [&](std::size_t b) { shoot(active[b]); });
      out.flakes += std::uint64_t(batch) * active.size();
      next.clear();
      for (Bucket& bucket : active) judge(bucket, next, out);
      std::swap(active, next);
    }
    smooth(out);
    return out;
  }

 private:
  // Squares of `largest` cells, in which sites hang together that are one surface; of a column one at most: what is
  // below a board and what is on it hang together by a slope beside it, and would share a bucket down to a single cell.
  std::vector<detail::Bucket> first_buckets() {
    const auto& sites = columns_.sites();
    std::vector<detail::Bucket> out;
    std::vector<bool> seen(sites.size());
    std::vector<std::uint32_t> waiting, found;
    order_.reserve(sites.size());
    for (std::uint32_t s = 0; s < sites.size(); ++s) {
      if (seen[s]) continue;
      const auto home = square_of(s);
      std::uint64_t taken = cell_of(s, home);
      found.clear();
      waiting.assign(1, s), seen[s] = true;
      while (!waiting.empty()) {
        const std::uint32_t at = waiting.back();
        waiting.pop_back();
        found.push_back(at);
        for (const auto& [di, dj] : beside_) {
          const std::uint32_t other = columns_.joined(at, di, dj, tops_.z);
          if (other == Columns::none || seen[other] || square_of(other) != home) continue;
          if (taken & cell_of(other, home)) continue;
          taken |= cell_of(other, home);
          seen[other] = true;
          waiting.push_back(other);
        }
      }
      std::sort(found.begin(), found.end());
      const auto first = std::uint32_t(order_.size());
      order_.insert(order_.end(), found.begin(), found.end());
      out.push_back(bucket_of(first, std::uint32_t(order_.size()), home[0], home[1], largest));
    }
    return out;
  }
  std::array<std::int32_t, 2> square_of(std::uint32_t s) const {
    const auto [i, j] = columns_.place(s);
    constexpr auto edge = std::int32_t(largest);
    return {i / edge * edge, j / edge * edge};
  }
  // The bit of a site's cell in its square.
  std::uint64_t cell_of(std::uint32_t s, const std::array<std::int32_t, 2>& home) const {
    static_assert(largest * largest <= 64);
    const auto [i, j] = columns_.place(s);
    return std::uint64_t{1} << (std::uint32_t(i - home[0]) * largest + std::uint32_t(j - home[1]));
  }
  // The bucket of the sites order_[first..last), put in order by quarters. While one quarter of its square holds them
  // all, that quarter takes the square's place: one has none to differ from.
  detail::Bucket bucket_of(std::uint32_t first, std::uint32_t last, std::int32_t i, std::int32_t j,
                           std::uint32_t edge) {
    detail::Bucket out{};
    const auto quarter = [&](std::uint32_t s) {
      const auto [a, b] = columns_.place(s);
      const auto half = std::int32_t(edge / 2);
      return edge == 1 ? 0 : 2 * (a - i >= half) + (b - j >= half);
    };
    const auto begin = order_.begin() + first, end = order_.begin() + last;
    while (edge > 1 &&
           std::all_of(begin, end, [&](std::uint32_t s) { return quarter(s) == quarter(*begin); })) {
      const auto q = quarter(*begin);
      edge /= 2;
      i += q / 2 * std::int32_t(edge), j += q % 2 * std::int32_t(edge);
    }
    out.i = i, out.j = j, out.edge = edge;
    std::stable_sort(begin, end, [&](std::uint32_t a, std::uint32_t b) { return quarter(a) < quarter(b); });
    std::uint32_t at = first;
    for (int q = 0; q < 5; ++q) {
      while (at < last && quarter(order_[at]) < q) ++at;
      out.quarter[q] = at;
    }
    out.quarter[4] = last;
    return out;
  }

  // Follow one batch of flakes from the sites of each quarter in turn.
  void shoot(detail::Bucket& bucket) {
    int held = 0;
    for (int q = 0; q < 4; ++q) held += bucket.quarter[q + 1] > bucket.quarter[q];
    for (int q = 0, done = 0; q < 4; ++q) {
      const std::uint32_t first = bucket.quarter[q], count = bucket.quarter[q + 1] - first;
      if (count == 0) continue;
      const std::uint32_t flakes = batch * std::uint32_t(done + 1) / std::uint32_t(held) -
                                   batch * std::uint32_t(done) / std::uint32_t(held);
      ++done;
      for (std::uint32_t k = 0; k < flakes; ++k) {
        const std::uint32_t number = bucket.tally[q].flakes;
        const std::uint64_t key =
            Draw::mixed(weather_.seed) ^ (std::uint64_t(order_[first]) << 32 | bucket.edge << 24 | number);
        Draw draw(key);
        const std::uint32_t s = order_[first + std::uint32_t((draw.word() >> 32) * count >> 32)];
        const double weight = follow(s, draw);
        bucket.tally[q].add(weight);
        SiteTally& of_site = of_site_[s];
        ++of_site.flakes, of_site.sum += weight;
      }
    }
  }
  double follow(std::uint32_t s, Draw& draw) const {
    const Raster& raster = columns_.raster();
    const auto [i, j] = columns_.place(s);
    const double lift = 1e-6 * raster.cell + 1e-12 * std::fabs(tops_.z[s]);
    return arrives(solids_, weather_, {raster.x(i), raster.y(j), tops_.z[s] + lift}, tops_.slope + 2 * s,
                   top_, draw);
  }

  // Split a bucket, count on, or write down what it has.
  void judge(const detail::Bucket& bucket, std::vector<detail::Bucket>& next, Exposure& out) {
    using detail::Tally;
    const Tally all = bucket.all();
    double least = Columns::inf, greatest = -Columns::inf, noise = 0;
    for (const Tally& t : bucket.tally) {
      if (t.flakes == 0) continue;
      least = std::fmin(least, t.mean()), greatest = std::fmax(greatest, t.mean());
      noise = std::fmax(noise, std::sqrt(2.0 * t.variance()));
    }
    const bool whole = bucket.edge > 1, full = all.flakes >= counting_.most;
    if (whole &&
        (greatest - least > std::fmax(counting_.detail, 3.0 * noise) || differs_inside(bucket, all))) {
      split(bucket, next);
      return;
    }
    const double error = std::sqrt(all.variance());
    const bool certain = error <= counting_.tolerance &&
                         (!whole || greatest - least + noise <= 2.0 * counting_.detail || full);
    if (!certain && !full) {
      next.push_back(bucket);
      return;
    }
    for (std::uint32_t k = bucket.first(); k < bucket.last(); ++k)
      out.share[order_[k]] = all.mean(), out.error[order_[k]] = error, out.bucket[order_[k]] = bucket.edge;
  }
  // Whether the sites of a bucket differ, although its quarters may be alike: below a rail over its middle, say.
  // What the sums of sites vary by beyond chance: sum over sites of (sum - flakes mean)^2 / flakes is, in units of the
  // variance of a flake, chi-squared of sites - 1 degrees if they are alike. Beyond four of its deviations they differ,
  // and that counts if they do by half the detail, root mean square: so do two halves that differ by the detail.
  bool differs_inside(const detail::Bucket& bucket, const detail::Tally& all) const {
    const double mean = all.mean(), one = all.variance() * all.flakes;
    double between = 0, freedom = -1;
    for (std::uint32_t k = bucket.first(); k < bucket.last(); ++k) {
      const SiteTally& t = of_site_[order_[k]];
      if (t.flakes == 0) continue;
      const double off = t.sum - t.flakes * mean;
      between += off * off / t.flakes, ++freedom;
    }
    const double excess = between / one - freedom, half = 0.5 * counting_.detail;
    return excess > 4.0 * std::sqrt(2.0 * freedom) && excess * one > half * half * all.flakes;
  }
  void split(const detail::Bucket& bucket, std::vector<detail::Bucket>& next) {
    const std::uint32_t edge = bucket.edge / 2;
    for (std::uint32_t k = bucket.first(); k < bucket.last(); ++k) of_site_[order_[k]] = {};
    for (int q = 0; q < 4; ++q) {
      if (bucket.quarter[q] == bucket.quarter[q + 1]) continue;
      next.push_back(bucket_of(bucket.quarter[q], bucket.quarter[q + 1],
                               bucket.i + q / 2 * std::int32_t(edge), bucket.j + q % 2 * std::int32_t(edge),
                               edge));
    }
  }

  // Let the steps between buckets of several cells flow apart: about as far as a bucket is wide, and without
  // changing the sum. Cells with a bucket of their own keep what was counted.
  void smooth(Exposure& out) const {
    std::vector<double> before;
    for (std::uint32_t pass = 0; pass < largest * largest; ++pass) {
      before = out.share;
      each_index(before.size(), [&](std::size_t s) {
        double flow = 0;
        for (const auto& [di, dj] : beside_) {
          const std::uint32_t o = columns_.joined(std::uint32_t(s), di, dj, tops_.z);
          if (o == Columns::none) continue;
          const std::uint32_t edge = std::min(out.bucket[s], out.bucket[o]);
          const bool near = std::fabs(before[o] - before[s]) <= 2.0 * counting_.detail;
          if (edge > 1 && pass < edge * edge && near) flow += before[o] - before[s];
        }
        out.share[s] = before[s] + 0.2 * flow;
      });
    }
  }

  static constexpr std::pair<int, int> beside_[4] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

  const Columns& columns_;
  const std::vector<const TriangleMesh*>& solids_;
  Weather weather_;
  Counting counting_;
  Tops tops_;
  double top_ = -Columns::inf;
  std::vector<std::uint32_t> order_;  // sites, those of a bucket side by side
  struct SiteTally {
    std::uint32_t flakes = 0;
    double sum = 0;
  };
  std::vector<SiteTally> of_site_;  // what the sites' buckets have counted at each
};

}  // namespace neve::snowfall
