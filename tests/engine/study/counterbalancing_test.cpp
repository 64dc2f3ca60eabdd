// Covers engine/study/methods/counterbalancing.cpp.
#include "engine/study/methods/counterbalancing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace springdrive::study {
namespace {

using Orders = std::vector<std::vector<int>>;

Orders orders_of(Counterbalancing kind, int conditions, int first, int participants) {
    Orders orders;
    for (int i = 0; i < participants; ++i) {
        orders.push_back(order_of(kind, conditions, first + i, key_of(1, 0)));
    }
    return orders;
}

/// How often each condition is in each place.
std::set<int> counts_of_places(const Orders &orders) {
    std::map<std::pair<int, std::size_t>, int> counts;
    for (const std::vector<int> &order : orders) {
        for (std::size_t place = 0; place < order.size(); ++place) {
            ++counts[{order[place], place}];
        }
    }
    const std::size_t n = orders.front().size();
    EXPECT_EQ(counts.size(), n * n);
    std::set<int> different;
    for (const auto &[of, count] : counts) {
        different.insert(count);
    }
    return different;
}

/// How often each condition directly follows each other one.
std::set<int> counts_of_neighbours(const Orders &orders) {
    std::map<std::pair<int, int>, int> counts;
    for (const std::vector<int> &order : orders) {
        for (std::size_t place = 1; place < order.size(); ++place) {
            ++counts[{order[place - 1], order[place]}];
        }
    }
    const std::size_t n = orders.front().size();
    EXPECT_EQ(counts.size(), n * (n - 1));
    std::set<int> different;
    for (const auto &[of, count] : counts) {
        different.insert(count);
    }
    return different;
}

TEST(Counterbalancing, BalancedLatinSquareBalancesPlacesAndNeighbours) {
    for (int n = 2; n <= 12; ++n) {
        const int participants =
            participants_to_balance(Counterbalancing::balanced_latin_square, n);
        EXPECT_EQ(participants, n % 2 == 0 ? n : 2 * n);
        const Orders orders =
            orders_of(Counterbalancing::balanced_latin_square, n, 1, participants);
        const std::set<int> once{participants / n};
        EXPECT_EQ(counts_of_places(orders), once) << n;
        EXPECT_EQ(counts_of_neighbours(orders), once) << n;
    }
}

TEST(Counterbalancing, FullHasEachOrderOnceAndALatinSquareInEachNParticipants) {
    for (int n = 2; n <= kMaxFullyCounterbalanced; ++n) {
        const int participants = participants_to_balance(Counterbalancing::full, n);
        const Orders orders = orders_of(Counterbalancing::full, n, 1, participants);
        EXPECT_EQ(std::set(orders.begin(), orders.end()).size(), orders.size()) << n;
        for (int first = 1; first <= participants; first += n) {
            EXPECT_EQ(counts_of_places(orders_of(Counterbalancing::full, n, first, n)),
                      std::set<int>{1});
        }
        // All orders: each neighbour (n − 1)! times.
        EXPECT_EQ(counts_of_neighbours(orders), std::set<int>{participants / n}) << n;
    }
    EXPECT_EQ(participants_to_balance(Counterbalancing::full, 6), 720);
}

TEST(Counterbalancing, StartsAgainWhenTheOrdersAreUsedUp) {
    EXPECT_EQ(orders_of(Counterbalancing::full, 3, 1, 6),
              orders_of(Counterbalancing::full, 3, 7, 6));
    EXPECT_EQ(orders_of(Counterbalancing::balanced_latin_square, 5, 1, 10),
              orders_of(Counterbalancing::balanced_latin_square, 5, 11, 10));
}

TEST(Counterbalancing, RandomOrdersAreThoseOfTheParticipant) {
    const Orders orders = orders_of(Counterbalancing::random, 4, 1, 200);
    EXPECT_EQ(std::set(orders.begin(), orders.end()).size(), 24U);
    EXPECT_EQ(orders, orders_of(Counterbalancing::random, 4, 1, 200));
    EXPECT_EQ(order_of(Counterbalancing::fixed, 3, 5, {}), (std::vector{0, 1, 2}));
    EXPECT_EQ(order_of(Counterbalancing::balanced_latin_square, 1, 5, {}), std::vector{0});
}

TEST(Counterbalancing, SaysHowManyConditionsItCanOrder) {
    EXPECT_EQ(validate(Counterbalancing::full, 6), "");
    EXPECT_EQ(validate(Counterbalancing::full, 7), "conditions is 7; it must be from 1 to 6");
    EXPECT_EQ(validate(Counterbalancing::balanced_latin_square, 7), "");
    EXPECT_EQ(validate(Counterbalancing::fixed, 0), "conditions is 0; it must be from 1 to 100");
}

} // namespace
} // namespace springdrive::study
