// The inertia of some of the engine's degrees of freedom, and what follows from its decomposition.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "rigid/sparse_rows.hpp"

namespace neve::rigid {

// The sum of a_k b_k, always in the same order.
inline double dot(const double* a, const double* b, std::size_t n) {
  double part[8] = {};
  std::size_t k = 0;
  for (; k + 8 <= n; k += 8) {
    for (std::size_t j = 0; j < 8; ++j) part[j] += a[k + j] * b[k + j];
  }
  for (std::size_t j = 0; k < n; ++k, ++j) part[j] += a[k] * b[k];
  return ((part[0] + part[4]) + (part[1] + part[5])) + ((part[2] + part[6]) + (part[3] + part[7]));
}

// A symmetric, positive definite matrix; later its factor L in L L^T.
class JointInertia {
 public:
  // M of the degrees of freedom `dofs`, rising; place: of each of the engine's, which of these it is.
  JointInertia(const EngineModel& model, const EngineData& data, const std::vector<std::size_t>& dofs,
               const std::vector<std::size_t>& place)
      : n_(dofs.size()), L_(n_ * n_) {
    for (std::size_t i = 0; i < n_; ++i) {
      const auto first = std::size_t(model.M_rowadr[dofs[i]]);
      for (std::size_t k = first; k < first + std::size_t(model.M_rownnz[dofs[i]]); ++k)
        row(i)[place[std::size_t(model.M_colind[k])]] = data.M[k];
    }
  }
  void add_to_diagonal(std::size_t i, double value) { row(i)[i] += value; }
  void add_square(const SparseRow& of, const std::vector<std::size_t>& place) {
    for (const auto& [a, at_a] : of.entries) {
      for (const auto& [b, at_b] : of.entries) {
        if (place[b] <= place[a]) row(place[a])[place[b]] += of.weight * at_a * at_b;
      }
    }
  }
  // Cholesky's decomposition. What has no inertia yields no further than the least pivot of the engine allows.
  void factor() {
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const double left = row(i)[j] - dot(row(i), row(j), j);
        row(i)[j] = i == j ? std::sqrt(std::max(left, least_pivot)) : left / row(j)[j];
      }
    }
  }
  // L^-1 x in place of x, which is zero before its number `first`.
  void forward(double* x, std::size_t first) const {
    for (std::size_t i = first; i < n_; ++i)
      x[i] = (x[i] - dot(row(i) + first, x + first, i - first)) / row(i)[i];
  }
  // L^-T x in place of x.
  void backward(double* x) const {
    for (std::size_t i = n_; i-- > 0;) {
      x[i] /= row(i)[i];
      for (std::size_t k = 0; k < i; ++k) x[k] -= row(i)[k] * x[i];
    }
  }

 private:
  static constexpr double least_pivot = 1e-15;
  double* row(std::size_t i) { return L_.data() + n_ * i; }
  const double* row(std::size_t i) const { return L_.data() + n_ * i; }

  std::size_t n_;
  std::vector<double> L_;  // row by row; what is above the diagonal does not count
};

}  // namespace neve::rigid
