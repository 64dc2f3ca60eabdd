#include "engine/scene/load_messages.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::scene {

std::string LoadProgress::text() const {
    constexpr std::array<const char *, 6> kStages = {"reading the file",
                                                     "gathering triangles",
                                                     "bending smooth surfaces",
                                                     "placing the scene",
                                                     "preparing the surface for touch",
                                                     "measuring models"};
    const std::string stage = kStages[static_cast<std::size_t>(stage_.load())];
    const float fraction = fraction_;
    if (fraction < 0.0F) {
        return stage;
    }
    const long percent = std::lround(100.0 * std::clamp(static_cast<double>(fraction), 0.0, 1.0));
    return stage + ", " + std::to_string(percent) + " %";
}

namespace {

constexpr std::size_t kNamesInFull = 3;

} // namespace

void WarningList::add(const std::string &text) { ++group_of("", nullptr, text).count; }

void WarningList::add_of(const std::string &owner, const void *identity, const std::string &text) {
    group_of(owner, identity, text);
}

void WarningList::add_of(const std::string &owner, const void *identity, std::size_t number,
                         const std::string &text) {
    Group &group = group_of(owner, identity, text);
    group.has_number = true;
    group.number += number;
}

WarningList::Group &WarningList::group_of(const std::string &owner, const void *identity,
                                          const std::string &text) {
    const std::size_t end_of_kind = std::min(owner.find(' '), owner.size());
    const std::string kind = owner.substr(0, end_of_kind);
    const auto [entry, is_new] = index_.try_emplace({kind, text}, groups_.size());
    if (is_new) {
        groups_.push_back({.kind = kind, .text = text});
    }
    Group &group = groups_[entry->second];
    if (end_of_kind == owner.size() || (identity != nullptr && identity == group.last_identity)) {
        return group;
    }
    group.last_identity = identity;
    ++group.count;
    if (group.first_names.size() < kNamesInFull) {
        group.first_names.push_back(owner.substr(end_of_kind + 1));
    }
    return group;
}

std::vector<std::string> WarningList::lines() const {
    std::vector<std::string> lines;
    for (const Group &group : groups_) {
        if (lines.size() + 1 == kMaxWarningLines && groups_.size() > kMaxWarningLines) {
            lines.push_back("and " + std::to_string(groups_.size() - lines.size()) +
                            " more remarks");
            break;
        }
        std::string line = group.kind + (group.first_names.size() > 1 ? "s" : "");
        for (std::size_t i = 0; i < group.first_names.size(); ++i) {
            line += (i == 0 ? " " : ", ") + group.first_names[i];
        }
        if (group.count > kNamesInFull && !group.first_names.empty()) {
            line += " and " + std::to_string(group.count - kNamesInFull) + " more";
        }
        line += (line.empty() ? "" : ": ") +
                (group.has_number ? std::to_string(group.number) + " " : "") + group.text;
        lines.push_back(std::move(line));
    }
    return lines;
}

} // namespace springdrive::scene
