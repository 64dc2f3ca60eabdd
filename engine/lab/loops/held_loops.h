// Every loop that a tuning has to keep stable, ready to be tried with gain after gain: each hand
// and those between, at each configuration, each motor by itself and all together, at any η from
// rigid to free.
#pragma once

#include "engine/lab/loops/stability_case.h"

#include <cstddef>
#include <string>
#include <vector>

namespace springdrive::loops {

/// One loop: what moves, and how much of its motion the law takes for an error.
struct HeldLoop {
    LinearLoop loop;
    Eigen::MatrixXd share; ///< see `held_share`, η included
    std::string hand;
    double eta = 0.0;
};

class HeldLoops {
public:
    /// @param which  its gains, η and freedom do not matter. One motor at a time, and three at a
    ///        grid of configurations in the workspace, unless it has a rotor of its own.
    explicit HeldLoops(const StabilityCase &which);

    // Of gains that are tried; dR, servo rate and delay are those that the loops were made for.

    /// The first that is unstable, or `count()`. Those that failed lately are tried first.
    /// Not thread-safe, as it remembers them.
    [[nodiscard]] std::size_t first_unstable(const Gains &gains);

    /// Whether all of some loops are stable.
    [[nodiscard]] bool are_stable(const std::vector<std::size_t> &some, const Gains &gains) const;

    [[nodiscard]] bool is_stable(std::size_t loop, const Gains &gains) const;

    /// See linear_loop.h.
    [[nodiscard]] double largest_eigenvalue(std::size_t loop, const Gains &gains) const;

    [[nodiscard]] std::size_t count() const { return loops_.size(); }
    [[nodiscard]] const HeldLoop &operator[](std::size_t loop) const { return loops_[loop]; }

private:
    std::vector<HeldLoop> loops_;
    std::vector<std::size_t> order_; ///< to try them in
};

} // namespace springdrive::loops
