#include "engine/contact/bvh/box_split.h"

#include "base/wanted.h"
#include "engine/contact/bvh/box_bins.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

namespace springdrive::contact {

namespace {

[[nodiscard]] std::size_t largest_lane(Float4 values) noexcept {
    const std::size_t of_first_two = values[1] > values[0] ? 1 : 0;
    return values[2] > values[of_first_two] ? 2 : of_first_two;
}

} // namespace

BoxRun BoxSplitter::run(std::uint32_t first, std::uint32_t count) const noexcept {
    BoxRun run{first, count, {}, {}};
    for (const NumberedBox &box : boxes_.subspan(first, count)) {
        run.bounds.extend(box.bounds());
        run.twice_centres.extend({box.twice_centre(), box.twice_centre()});
    }
    return run;
}

BoxFork BoxSplitter::fork(const BoxRun &whole, SplitRule rule) const {
    BoxFork fork;
    fork.runs[0] = whole;
    fork.size = 1;
    // The run to be split next is the one that is looked into most often, of those that would not
    // fit into one node.
    const auto choose = [&](std::uint32_t least_count, std::uint32_t most_count) {
        std::optional<std::size_t> chosen;
        float largest = -1.0F;
        for (std::size_t i = 0; i < fork.size; ++i) {
            const BoxRun &run = fork.runs[i];
            const float weight =
                rule == SplitRule::halves ? static_cast<float>(run.count) : half_area(run.bounds);
            if (run.count >= least_count && run.count <= most_count && weight > largest) {
                largest = weight;
                chosen = i;
            }
        }
        return chosen;
    };
    while (fork.size < kBoxLanes) {
        const auto too_large = choose(kBoxLanes + 1, whole.count);
        if (!too_large) {
            break;
        }
        stop_if_given_up();
        split(fork, *too_large, rule);
    }
    while (fork.size < kBoxLanes) {
        const auto lanes_left = static_cast<std::uint32_t>(kBoxLanes - fork.size);
        const auto fitting = choose(2, lanes_left + 1);
        if (!fitting) {
            break;
        }
        open(fork, *fitting);
    }
    return fork;
}

float BoxSplitter::half_area(const Bounds &bounds) const noexcept {
    const Float4 size = bounds.upper - bounds.lower + all_lanes(gap_m_);
    const Float4 area = size * __builtin_shufflevector(size, size, 1, 2, 0, 3);
    return area[0] + area[1] + area[2];
}

BoxSplitter::Wall BoxSplitter::cheapest_wall(const BoxRun &whole) const noexcept {
    const BoxBinning binning(whole.twice_centres, whole.count);
    BoxBins bins(binning.bins());
    for (const NumberedBox &box : boxes_.subspan(whole.first, whole.count)) {
        bins.add(box.bounds(), binning.bins_of(box.twice_centre()));
    }
    // A node costs the same whether it is full or not.
    const auto cost = [this](const BoxBin &side) {
        const std::size_t nodes = (side.count + kBoxLanes - 1) / kBoxLanes;
        return half_area(side.bounds) * static_cast<float>(nodes);
    };
    Wall best;
    for (int axis = 0; axis < 3; ++axis) {
        std::array<float, kMostBoxBins> cost_above{};
        BoxBin above;
        for (int i = binning.bins() - 1; i > 0; --i) {
            above.add(bins.at(axis, i));
            cost_above[static_cast<std::size_t>(i)] = cost(above);
        }
        BoxBin below;
        for (int i = 1; i < binning.bins(); ++i) {
            below.add(bins.at(axis, i - 1));
            const float sum = cost(below) + cost_above[static_cast<std::size_t>(i)];
            if (sum < best.cost && below.count > 0 && below.count < whole.count) {
                best = {axis, i, sum};
            }
        }
    }
    return best;
}

std::uint32_t BoxSplitter::reorder(const BoxRun &whole, const Wall &wall) const noexcept {
    const BoxBinning binning(whole.twice_centres, whole.count);
    const std::span<NumberedBox> boxes = boxes_.subspan(whole.first, whole.count);
    // Swaps always and advances if it was right: whether it is cannot be foreseen.
    std::size_t below = 0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const NumberedBox box = boxes[i];
        boxes[i] = boxes[below];
        boxes[below] = box;
        below += binning.bins_of(box.twice_centre())[wall.axis] < wall.bin ? 1 : 0;
    }
    return static_cast<std::uint32_t>(below);
}

std::uint32_t BoxSplitter::reorder_in_halves(const BoxRun &whole) const {
    const std::size_t axis = largest_lane(whole.twice_centres.upper - whole.twice_centres.lower);
    const std::span<NumberedBox> boxes = boxes_.subspan(whole.first, whole.count);
    const std::size_t half = boxes.size() / 2;
    std::ranges::nth_element(boxes, std::next(boxes.begin(), static_cast<std::ptrdiff_t>(half)),
                             [axis](const NumberedBox &a, const NumberedBox &b) {
                                 return a.twice_centre()[axis] < b.twice_centre()[axis];
                             });
    return static_cast<std::uint32_t>(half);
}

void BoxSplitter::split(BoxFork &fork, std::size_t index, SplitRule rule) const {
    const BoxRun whole = fork.runs[index];
    const Wall wall = rule == SplitRule::surface_area ? cheapest_wall(whole) : Wall{};
    const std::uint32_t below = wall.axis >= 0 ? reorder(whole, wall) : reorder_in_halves(whole);
    std::move_backward(fork.runs.begin() + index + 1, fork.runs.begin() + fork.size,
                       fork.runs.begin() + fork.size + 1);
    fork.runs[index] = run(whole.first, below);
    fork.runs[index + 1] = run(whole.first + below, whole.count - below);
    ++fork.size;
}

void BoxSplitter::open(BoxFork &fork, std::size_t index) const noexcept {
    const BoxRun whole = fork.runs[index];
    const std::size_t added = whole.count - 1;
    std::move_backward(fork.runs.begin() + index + 1, fork.runs.begin() + fork.size,
                       fork.runs.begin() + fork.size + added);
    for (std::uint32_t i = 0; i < whole.count; ++i) {
        fork.runs[index + i] = run(whole.first + i, 1);
    }
    fork.size += added;
}

} // namespace springdrive::contact
