// Whether what a window reports is drawn side by side, within its panels.
#pragma once

#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

namespace springdrive::testing {

/// A widget that a reader sees.
struct ShownBox {
    std::string id;
    std::string text;
    double left, top, right, bottom;
};

/// @param panel  only of this one; empty for all
[[nodiscard]] inline std::vector<ShownBox> shown_boxes(const Report &report,
                                                       const std::string &panel) {
    static const std::set<std::string> kSurfaces{"panel", "tooltip"};
    std::vector<ShownBox> boxes;
    for (const auto &item : report.all().at("items")) {
        const bool is_in_panel =
            panel.empty() || item.at("id").get<std::string>().starts_with(panel + "/");
        if (is_in_panel && !kSurfaces.contains(item.at("kind")) && item.value("visible", true)) {
            boxes.push_back({item.at("id"), item.at("text"), item.at("x"), item.at("y"),
                             item.at("x").get<double>() + item.at("width").get<double>(),
                             item.at("y").get<double>() + item.at("height").get<double>()});
        }
    }
    return boxes;
}

[[nodiscard]] inline bool overlap(const ShownBox &a, const ShownBox &b) {
    constexpr double kRounding = 1.0; // of places to pixels
    return std::min(a.right, b.right) - std::max(a.left, b.left) > kRounding &&
           std::min(a.bottom, b.bottom) - std::max(a.top, b.top) > kRounding;
}

/// Expects that nothing in that panel is clipped, beyond the window or over something else.
inline void expect_side_by_side(const Report &report, const std::string &panel,
                                const std::string &where) {
    for (const auto &item : report.all().at("items")) {
        EXPECT_FALSE(item.at("id").get<std::string>().starts_with(panel) &&
                     item.value("overflows", false))
            << where << ": " << item.dump();
    }
    const std::vector<ShownBox> boxes = shown_boxes(report, panel);
    EXPECT_FALSE(boxes.empty()) << panel;
    const double width = report.all().at("window").at("width");
    const double height = report.all().at("window").at("height");
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        EXPECT_LE(boxes[i].right, width + 1.0) << where << ": " << boxes[i].id;
        EXPECT_LE(boxes[i].bottom, height + 1.0) << where << ": " << boxes[i].id;
        for (std::size_t j = i + 1; j < boxes.size(); ++j) {
            EXPECT_FALSE(overlap(boxes[i], boxes[j]))
                << where << ": \"" << boxes[i].id << "\" (" << boxes[i].text << ") and \""
                << boxes[j].id << "\" (" << boxes[j].text << ")";
        }
    }
}

} // namespace springdrive::testing
