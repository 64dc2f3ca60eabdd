// What the loading of a scene tells: its progress, and warnings on what it leaves out.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::scene {

/// The progress of loading, and its cancellation. Written by the thread that loads; any thread may
/// read it.
class LoadProgress {
public:
    enum class Stage : std::uint8_t {
        reading,   ///< the file's bytes and structure
        gathering, ///< its triangles
        bending,   ///< smooth nodes
        placing,   ///< in the device's frame
        preparing, ///< the surface for the touch
        measuring, ///< which model the scene gets
    };

    /// @param known whether `advance_to` will be called
    void begin(Stage stage, bool known) noexcept {
        fraction_ = known ? 0.0F : kUnknown;
        stage_ = stage;
    }

    /// @param fraction of the stage, from 0 to 1
    void advance_to(double fraction) noexcept { fraction_ = static_cast<float>(fraction); }

    [[nodiscard]] Stage stage() const noexcept { return stage_; }

    /// For people: "gathering triangles, 40 %".
    [[nodiscard]] std::string text() const;

    /// Cancels loading, from any thread. It ends with Cancelled at its next check, of which there
    /// are many in a second.
    void give_up() noexcept { is_given_up_ = true; }
    /// For the thread that loads, see StopScope.
    [[nodiscard]] const std::atomic<bool> &is_cancelled() const noexcept { return is_given_up_; }

private:
    static constexpr float kUnknown = -1.0F;

    std::atomic<Stage> stage_{Stage::reading};
    std::atomic<float> fraction_{kUnknown};
    std::atomic<bool> is_given_up_{false};
};

/// However many warnings there are, `WarningList::lines` gives no more lines than this.
inline constexpr std::size_t kMaxWarningLines = 60;

/// Warnings with equal ones on several things on one line.
class WarningList {
public:
    /// On the file as a whole, or on something that nothing else resembles.
    void add(const std::string &text);

    /// On one of several things.
    /// @param owner what it is, a space and its name: "node 'pad'"
    /// @param identity warnings in a row with the same one count once; null if each counts
    void add_of(const std::string &owner, const void *identity, const std::string &text);

    /// The same for a text that begins with a number; a line gives the sum.
    void add_of(const std::string &owner, const void *identity, std::size_t number,
                const std::string &text);

    /// "node 'a': it is so", or "nodes 'a', 'b', 'c' and 4 more: it is so"; in the order in which
    /// the first of each was added.
    [[nodiscard]] std::vector<std::string> lines() const;

private:
    struct Group {
        std::string kind; ///< "node"
        std::string text;
        bool has_number = false;
        std::size_t number = 0;
        std::size_t count = 0;
        std::vector<std::string> first_names{};
        const void *last_identity = nullptr;
    };

    Group &group_of(const std::string &owner, const void *identity, const std::string &text);

    std::vector<Group> groups_;
    std::map<std::pair<std::string, std::string>, std::size_t> index_; ///< by kind and text
};

} // namespace springdrive::scene
