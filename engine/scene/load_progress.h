// How far the loading of a scene has come, and whether anybody still wants it.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace springdrive::scene {

/// Whoever loads writes it, any thread may read it meanwhile.
class LoadProgress {
public:
    enum class Stage : std::uint8_t {
        reading,   ///< the file's bytes and structure
        gathering, ///< its triangles
        bending,   ///< smooth nodes
        placing,   ///< in the device's frame, for hand and eye
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

    /// Any thread: nobody waits for the scene any more. Loading ends with NotWanted where it next
    /// looks, which it does many times a second.
    void give_up() noexcept { is_given_up_ = true; }
    /// For whoever loads, see GivenUpBy.
    [[nodiscard]] const std::atomic<bool> &is_given_up() const noexcept { return is_given_up_; }

private:
    static constexpr float kUnknown = -1.0F;

    std::atomic<Stage> stage_{Stage::reading};
    std::atomic<float> fraction_{kUnknown};
    std::atomic<bool> is_given_up_{false};
};

} // namespace springdrive::scene
