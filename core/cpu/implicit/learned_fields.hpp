// Learned energies of all particles: a network for each law, and where the energy of each particle is expanded.
#pragma once

#include "cpu/implicit/flow.hpp"
#include "cpu/implicit/learned.hpp"

namespace neve {

// The place of a law in the list.
template <class Law>
constexpr int law_place() {
  int place = 0, found = -1;
  each(Laws{}, [&](auto law) {
    if (std::is_same_v<decltype(law), Law>) found = place;
    ++place;
  });
  return found;
}

template <class T>
class LearnedEnergies {
  using R = Lanes<T>;

 public:
  // Take the law's return map from `net`.
  void learn(int law, LearnedNet net) {
    nets_.resize(Laws::size);
    nets_[static_cast<std::size_t>(law)] = std::move(net);
  }
  bool are_used() const { return !nets_.empty(); }
  void resize(std::size_t n) {
    if (n > e0_.size()) C_.resize(n), e0_.resize(n), scalars_.resize(n);
  }

  // Expand the energies of a pack around F.
  void expand(const Model<T>& model, const State<T>& state, std::size_t p, int count, const Mat3<R>& F,
              const R& J_P) {
    using Out = Expansion<R>;
    const Mapped<R> end = detail::flowed_snow(model, state, p, count, F, J_P);
    const Out at = by_net<Out>(
        model, state, p, count, F, [&](const LearnedNet& net, auto law, const auto& q, const auto& own) {
          const R frozen = hardens_within<decltype(law)> ? J_P : end.J_P;
          return neve::expand(net, law, q, own, frozen, end.stress.tau, detail::inverse_transposed(own));
        });
    store_matrix(C_, p, at.C, count);
    for (int k = 0; k < 3; ++k) store(e0_.column(k) + p, at.e0[k], count);
    store(scalars_.column(0) + p, at.J_P, count);
    store(scalars_.column(1) + p, at.r, count);
  }

  // P of a pack at F, ice left out, and its derivative if that is wanted.
  LearnedResponse<R> respond(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                             const Mat3<R>& F, const Svd3<R>& at, bool with_tangent) const {
    using Out = LearnedResponse<R>;
    const auto number = [&](const T* column) { return load<R>(column + p, count); };
    const Expansion<R> from{{number(e0_.column(0)), number(e0_.column(1)), number(e0_.column(2))},
                            number(scalars_.column(0)),
                            load_matrix<R>(C_, p, count),
                            number(scalars_.column(1))};
    return by_net<Out>(model, state, p, count, F,
                       [&](const LearnedNet& net, auto law, const auto& q, const auto& own) {
                         return neve::respond(net, law, q, own, at, from, with_tangent);
                       });
  }

 private:
  template <class Out, class F>
  Out by_net(const Model<T>& model, const State<T>& state, std::size_t p, int count, const Mat3<R>& at,
             F&& f) const {
    return detail::by_law<Out>(model, state, p, count, at,
                               [&](auto law, const auto& q, const auto& own) -> Out {
                                 using Law = decltype(law);
                                 if constexpr (is_learned<Law>) {
                                   return f(nets_[std::size_t(law_place<Law>())], law, q, own);
                                 } else {
                                   return Out{};
                                 }
                               });
  }

  std::vector<LearnedNet> nets_;  // by law
  Field<T, 9> C_;
  Field<T, 3> e0_;
  Field<T, 2> scalars_;  // J_P, r
};

}  // namespace neve
