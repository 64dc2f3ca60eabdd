#include "app/doctor/trial.h"

#include "app/doctor/check.h"
#include "app/doctor/child_answer.h"
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "device/usb/driver/board_survey.h"
#include "device/usb/driver/libusb_port.h"
#include "engine/record/record_header.h"
#include "engine/servo/real_time.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <optional>
#include <thread>

// Answers pass between processes as JSON. Both ends are this program, but an answer may be that of
// a process that went wrong: what does not parse is none.
namespace springdrive::usb {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SurveyedBoard, bus, address, sysfs_name, serial, speed, firmware,
                                   obstacle, problem)
} // namespace springdrive::usb

namespace springdrive::app::doctor {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RightsTrial, has_answered, priority, priority_refused,
                                   memory_locked, idle_is_short)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PictureTrial, has_answered, display_problem, window_problem,
                                   version, renderer)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DiskTrial, has_answered, refused, written_bytes_per_s,
                                   longest_sync_s, free_bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(UsbTrial, has_answered, problem, boards)

namespace {

/// The priority last, and on a thread that ends at once: with it, this process could hold up a
/// servo that is running.
RightsTrial try_rights(int priority) {
    RightsTrial trial;
    const servo::ShortIdle short_idle;
    trial.idle_is_short = short_idle.warning().empty();
    trial.priority = priority;
    trial.memory_locked = servo::request_locked_memory();
    std::thread([&] { trial.priority_refused = request_priority(priority); }).join();
    return trial;
}

UsbTrial try_usb() {
    UsbTrial trial;
    try {
        trial.boards = usb::survey_boards();
    } catch (const InputError &error) {
        trial.problem = error.what();
    }
    return trial;
}

/// In a process of its own, from now on.
template <typename Trial> class Asked {
public:
    explicit Asked(const std::function<Trial()> &work)
        : child_([&work] {
              Trial trial = work();
              trial.has_answered = true;
              return nlohmann::json(trial).dump(-1, ' ', true,
                                                nlohmann::json::error_handler_t::replace);
          }) {}

    [[nodiscard]] Trial by(ChildAnswer::Clock::time_point deadline) {
        const std::optional<std::string> answer = child_.by(deadline);
        try {
            return answer ? nlohmann::json::parse(*answer).get<Trial>() : Trial();
        } catch (const nlohmann::json::exception &) {
            return {};
        }
    }

private:
    ChildAnswer child_;
};

} // namespace

double record_bytes_per_s(double servo_hz) {
    return record::record_header(servo_hz).row_bytes * servo_hz;
}

Trials try_all(const Purpose &purpose) {
    const auto deadline = ChildAnswer::Clock::now() + kTrialTime;
    const int priority = purpose.uses_usb ? usb::kPortThreadPriority : servo::kServoPriority;
    const auto second_bytes = static_cast<std::size_t>(record_bytes_per_s(purpose.servo_hz));
    Asked<UsbTrial> usb(try_usb);
    Asked<PictureTrial> picture(try_picture);
    Asked<DiskTrial> disk([&] { return try_disk(purpose.folder, second_bytes); });
    // Last: with its priority it could hold up the others on a computer with one processor.
    Asked<RightsTrial> rights([&] { return try_rights(priority); });
    Trials trials;
    trials.rights = rights.by(deadline);
    trials.disk = disk.by(deadline);
    trials.picture = picture.by(deadline);
    trials.usb = usb.by(deadline);
    return trials;
}

} // namespace springdrive::app::doctor
