#include "engine/study/methods/counterbalancing.h"

#include "base/assertions.h"
#include "engine/study/methods/wrong_value.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace springdrive::study {

namespace {

std::vector<int> listed(int count) {
    std::vector<int> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    return order;
}

int factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }

/// Conditions 1 to n − 1 in each of their (n − 1)! orders behind condition 0, and each of these
/// turned by 0 to n − 1 places.
std::vector<int> full_order(int count, int index) {
    std::vector<int> order = listed(count);
    for (int i = 0; i < index / count; ++i) {
        std::next_permutation(order.begin() + 1, order.end());
    }
    std::rotate(order.begin(), order.begin() + index % count, order.end());
    return order;
}

/// The row 0, 1, n − 1, 2, n − 2, … plus `index`, mod n: its differences are all different, so each
/// ordered pair of neighbours occurs once in n rows. With an odd n each difference occurs once
/// forwards in these rows and once in their mirror images.
std::vector<int> williams_order(int count, int index) {
    std::vector<int> order;
    for (int place = 0; place < count; ++place) {
        const int zigzag = place % 2 == 1 ? (place + 1) / 2 : count - place / 2;
        order.push_back((zigzag + index) % count);
    }
    if (index >= count) {
        std::ranges::reverse(order);
    }
    return order;
}

} // namespace

std::string validate(Counterbalancing kind, int conditions) {
    constexpr int kMax = 100;
    return unless_from_to("conditions", conditions, 1,
                          kind == Counterbalancing::full ? kMaxFullyCounterbalanced : kMax);
}

int participants_to_balance(Counterbalancing kind, int conditions) {
    switch (kind) {
    case Counterbalancing::full:
        return factorial(conditions);
    case Counterbalancing::balanced_latin_square:
        return conditions % 2 == 0 || conditions == 1 ? conditions : 2 * conditions;
    case Counterbalancing::fixed:
    case Counterbalancing::random:
        break;
    }
    return 1;
}

std::vector<int> order_of(Counterbalancing kind, int conditions, int participant, RandomKey key) {
    SPRINGDRIVE_ASSERT(participant >= 1 && validate(kind, conditions).empty());
    const int index = (participant - 1) % participants_to_balance(kind, conditions);
    switch (kind) {
    case Counterbalancing::full:
        return full_order(conditions, index);
    case Counterbalancing::balanced_latin_square:
        return williams_order(conditions, index);
    case Counterbalancing::fixed:
    case Counterbalancing::random:
        break;
    }
    std::vector<int> order = listed(conditions);
    if (kind == Counterbalancing::random) {
        shuffle(child(key, static_cast<std::uint64_t>(participant)), std::span(order));
    }
    return order;
}

} // namespace springdrive::study
