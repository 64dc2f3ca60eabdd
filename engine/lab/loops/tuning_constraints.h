// Every loop that a tuning has to keep stable, prepared for trying many gains: each structure of
// the case, each hand and those between, at each configuration, each motor alone and all together,
// at values of η from rigid to free.
#pragma once

#include "engine/lab/loops/stability_case.h"

#include <cstddef>
#include <string>
#include <vector>

namespace springdrive::loops {

/// One loop: the load, and the share of its motion that the law treats as an error.
struct TuningConstraint {
    LinearLoop loop;
    Eigen::MatrixXd share; ///< see `held_share`, η included
    std::string hand;
    double eta = 0.0;
    Structure structure{};
};

class TuningConstraints {
public:
    /// @param which  its gains, η and freedom are ignored. One motor at a time, and all three at a
    ///        grid of configurations in the workspace unless the case has a rotor of its own.
    explicit TuningConstraints(const StabilityCase &which);

    // Gains vary between calls; dR, servo rate and delay are those of the case.

    /// The first unstable loop, or `count()`. Loops that failed recently are tried first. Not
    /// thread-safe, as it keeps their order.
    [[nodiscard]] std::size_t first_unstable(const Gains &gains);

    /// Whether all of the given loops are stable.
    [[nodiscard]] bool are_stable(const std::vector<std::size_t> &some, const Gains &gains) const;

    [[nodiscard]] bool is_stable(std::size_t loop, const Gains &gains) const;

    /// See linear_loop.h.
    [[nodiscard]] double largest_eigenvalue(std::size_t loop, const Gains &gains) const;

    [[nodiscard]] std::size_t count() const { return loops_.size(); }
    [[nodiscard]] const TuningConstraint &operator[](std::size_t loop) const {
        return loops_[loop];
    }

private:
    std::vector<TuningConstraint> loops_;
    std::vector<std::size_t> order_; ///< to try them in
};

} // namespace springdrive::loops
