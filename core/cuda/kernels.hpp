// The kernels by name, each with the threads of its blocks: for whoever makes entry points of them.
#pragma once

#include "cuda/g2p2g.hpp"
#include "cuda/grid/domain.hpp"
#include "cuda/grid_update.hpp"
#include "cuda/p2g.hpp"
#include "cuda/passes.hpp"
#include "cuda/picture.hpp"
#include "cuda/sums.hpp"

// each(name, threads, function): the function takes a Step; C is a Choice, T its precision.
// clang-format off
#define NEVE_KERNELS(each)                                  \
  each(find_owners, sort_threads, find_owners<C>)           \
  each(part_particles, sort_threads, part_particles<T>)     \
  each(find_homes, sort_threads, find_homes<C>)             \
  each(sort_homes, sort_threads, sort_homes<T>)             \
  each(rank_homes, sort_threads, rank_homes<T>)             \
  each(count_homes, sort_threads, count_homes<T>)           \
  each(scan_homes, scan_threads, scan_homes<T>)             \
  each(place_particles, sort_threads, place_particles<C>)   \
  each(order_homes, sort_threads, order_homes<T>)           \
  each(permute, sort_threads, permute<T>)                   \
  each(find_blocks, sort_threads, find_blocks<T>)           \
  each(link_homes, sort_threads, link_homes<T>)             \
  each(refresh, particle_threads, refresh<C>)               \
  each(pace_step, pace_threads, pace_step<C>)               \
  each(clear_nodes, block_nodes, clear_nodes<C>)            \
  each(judge_step, pace_threads, judge_step<C>)             \
  each(p2g, home_threads, p2g<C>)                           \
  each(pack_halo, block_nodes, pack_halo<C>)                \
  each(unpack_halo, block_nodes, unpack_halo<C>)            \
  each(grid_update, block_nodes, grid_update<C>)            \
  each(body_response, block_nodes, body_response<C>)        \
  each(meet_bodies, block_nodes, meet_bodies<C>)            \
  each(report_nodes, report_threads, report_nodes<C>)       \
  each(g2p, gather_threads, g2p<C>)                         \
  each(g2p2g, gather_threads, g2p2g<C>)                     \
  each(measure_volumes, gather_threads, measure_volumes<C>) \
  each(scatter_lift, home_threads, scatter_lift<C>)         \
  each(gather_lift, gather_threads, gather_lift<C>)         \
  each(inspect, sum_threads, inspect<C>)                    \
  each(add_up, sum_threads, add_up<C>)                      \
  each(picture_ends, picture_threads, picture_ends<T>)      \
  each(draw_picture, picture_threads, draw_picture<T>)
// clang-format on
