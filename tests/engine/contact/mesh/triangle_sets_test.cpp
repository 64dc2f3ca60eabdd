// Covers engine/contact/mesh/triangle_sets.h.
#include "engine/contact/mesh/triangle_sets.h"

#include <gtest/gtest.h>

#include <random>

namespace springdrive::contact {
namespace {

/// Sets and turns as plain labels, all of them rewritten at each union.
class PlainSets {
public:
    explicit PlainSets(std::uint32_t count) {
        for (std::uint32_t i = 0; i < count; ++i) {
            label.push_back(i);
            is_turned.push_back(false);
        }
    }

    bool unite(std::uint32_t a, std::uint32_t b, bool are_opposite) {
        const bool is_odd = (is_turned[a] != is_turned[b]) != are_opposite;
        if (label[a] == label[b]) {
            return !is_odd;
        }
        const std::uint32_t from = label[b];
        for (std::uint32_t i = 0; i < label.size(); ++i) {
            if (label[i] == from) {
                label[i] = label[a];
                is_turned[i] = is_turned[i] != is_odd;
            }
        }
        return true;
    }

    std::vector<std::uint32_t> label;
    std::vector<bool> is_turned;
};

TEST(TriangleSets, AgreesWithPlainLabels) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 300; ++round) {
        constexpr std::uint32_t kCount = 30;
        TriangleSets sets(kCount);
        PlainSets plain(kCount);
        for (int i = 0; i < 40; ++i) {
            const auto a = static_cast<std::uint32_t>(random() % kCount);
            const auto b = static_cast<std::uint32_t>(random() % kCount);
            const bool are_opposite = random() % 2 == 0;
            ASSERT_EQ(sets.unite(a, b, are_opposite), plain.unite(a, b, are_opposite));
        }
        for (std::uint32_t a = 0; a < kCount; ++a) {
            ASSERT_LE(sets.root_of(a), a);
            for (std::uint32_t b = 0; b < kCount; ++b) {
                const bool are_together = sets.root_of(a) == sets.root_of(b);
                ASSERT_EQ(are_together, plain.label[a] == plain.label[b]);
                if (are_together) {
                    ASSERT_EQ(sets.place_of(a).is_opposite != sets.place_of(b).is_opposite,
                              plain.is_turned[a] != plain.is_turned[b]);
                }
            }
        }
    }
}

} // namespace
} // namespace springdrive::contact
