// An exhibit: what runs unattended among visitors, in place of the window's panels.
//
//   mouse, keys, tip ──► Course ──► scene, scripted hand, gains, view ──► session
//   session's safety ──► Recovery ──► reset of a simulation, lift of the hand ──► session
//                    button *go on* ──► session
//                    └─► DayWatch ──► DayLog
//
// Its screen shows large words, few buttons, and the read-outs at the arrow over the scene. All
// sizes are shares of the picture's size, so that they are legible at a distance whatever the
// screen's pixels. The rule: digits are at least 6.5 % of the picture's height. On a screen 27 cm
// high (22 inches) or higher that is 17.5 mm: half a degree at two metres.
#pragma once

#include "app/exhibit/course.h"
#include "app/exhibit/day_log.h"
#include "app/exhibit/tour.h"
#include "app/exhibit/trip_recovery.h"
#include "app/stage/view_control.h"
#include "app/view/camera.h"
#include "app/view/view_state.h"
#include "app/widgets/rectangle.h"
#include "app/window/window.h"
#include "engine/control/tuning.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::exhibit {

/// Of the force's arrow, which has to be seen at a distance too: 1 N is 60 mm.
inline constexpr ArrowSize kArrow{4.0 * kArrowMetresPerNewton, 2.0};

struct KioskReadOut {
    double force_N = 0.0;
    std::optional<double> angle_rad; ///< from the surface's normal to the push
    Vector3 arrow_from_m{Vector3::Zero()};
    Vector3 arrow_m{Vector3::Zero()}; ///< end of the force's arrow
};

struct KioskShown {
    const Course &course;
    const TripRecovery &recovery;
    bool has_script = true; ///< a scripted hand shows the scene
    std::string title{};
    std::string sentence{};
    std::string stop{}; ///< what stopped it; else empty
    control::MotionMap map = control::MotionMap::transpose;
    std::optional<KioskReadOut> read_out{}; ///< in contact
};

/// Buttons that were pressed.
struct KioskAnswer {
    bool my_turn = false;
    bool other_map = false;
    bool next_scene = false;
    bool next_visitor = false;
    bool stop = false;
    bool go_on = false;
};

[[nodiscard]] KioskAnswer draw_kiosk(const KioskShown &shown, const Camera &camera,
                                     const Rectangle &view, const Window::LargeText &text);

/// The part of the view that none of the fixed words cover.
[[nodiscard]] Rectangle free_in_kiosk(const Rectangle &view);

/// What the kiosk acts on; of the screen.
struct KioskParts {
    ScriptContext stage;
    ViewControl &view;
    double frame_s = 0.0;   ///< since the last one
    bool is_inside = false; ///< the tip lies in a solid
};

/// The exit status of a kiosk that only a new start helps.
inline constexpr int kStartAgain = 3;

enum class KioskEnding : std::uint8_t { none, asked, start_again };

class Kiosk {
public:
    /// Lowers the servo's limits, which must not have been started.
    /// @param log  of the day; empty: none
    Kiosk(session::Session &session, std::filesystem::path log);

    /// A key that was pressed; the emergency stop is the window's.
    void obey(const KeyPress &key);

    /// Once a frame: draws, and does what is to be done.
    void update(const KioskParts &parts, const Rectangle &view, const Window::LargeText &text);

    /// At the end of the run.
    /// @param why  in a few words
    void finish(const std::string &why);

    [[nodiscard]] KioskEnding ending() const { return ending_; }
    [[nodiscard]] std::string take_error() { return log_.take_error(); } ///< of the log

private:
    [[nodiscard]] KioskShown shown(const KioskParts &parts) const;
    void note_visitor(const KioskParts &parts, const KioskAnswer &answer);
    void recover(const KioskParts &parts);
    void carry_out(const CourseOrders &orders, const KioskParts &parts);
    [[nodiscard]] bool tip_was_moved(const session::Session &session);
    void renew_read_out(const KioskParts &parts);
    void zero(session::Session &session);

    ScriptedDemo script_;
    Course course_{kTour.size()};
    TripRecovery recovery_;
    DayLog log_;
    DayWatch watch_;
    DayFigures figures_;
    KioskEnding ending_ = KioskEnding::none;
    CourseNow now_; ///< of the present frame
    std::vector<KeyPress> keys_;
    std::string error_;             ///< of loading it, as logged
    std::optional<Vector3> rest_m_; ///< of the tip of a real device
    std::optional<double> final_since_s_;
    std::optional<KioskReadOut> read_out_;
    double next_read_out_s_ = 0.0;
    bool is_finished_ = false;
};

} // namespace springdrive::app::exhibit
