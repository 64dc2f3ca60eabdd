// Something that takes many frames, as a coroutine that awaits the next frame:
//
//   Course<> wait(Frames &frames) { const SittingFrame frame = co_await frames.show(picture); ... }
//
//   what shows frames ──frame──► Frames::resume ──► the course that awaits it ──► next picture
//
// Courses await each other. `Frames::end` ends the innermost one that is awaited as
// `frames.until_end(course)`: it is destroyed where it waits, with all that it has on its stack.
// What they take by reference must be a variable of who awaits them: GCC 12 destroys some
// temporaries twice.
#pragma once

#include "app/study/participant/participant_picture.h"
#include "app/study/sitting/sitting_frame.h"
#include "base/assertions.h"

#include <coroutine>
#include <exception>
#include <optional>
#include <utility>

namespace springdrive::app::study_screen {

template <typename Result> struct CourseResult {
    std::optional<Result> result;

    void return_value(Result value) { result.emplace(std::move(value)); }
    Result take() { return *std::move(result); }
};
template <> struct CourseResult<void> {
    void return_void() {}
    void take() {}
};

/// Runs when it is awaited, or started by Frames.
template <typename Result = void> class Course {
public:
    struct promise_type : CourseResult<Result> {
        /// Goes on with whoever awaits the course.
        struct AtEnd {
            static bool await_ready() noexcept { return false; }
            static std::coroutine_handle<>
            await_suspend(std::coroutine_handle<promise_type> course) noexcept {
                return course.promise().awaiter;
            }
            static void await_resume() noexcept {}
        };

        Course get_return_object() {
            return Course(std::coroutine_handle<promise_type>::from_promise(*this));
        }
        static std::suspend_always initial_suspend() { return {}; }
        static AtEnd final_suspend() noexcept { return {}; }
        void unhandled_exception() { exception = std::current_exception(); }

        std::coroutine_handle<> awaiter = std::noop_coroutine();
        std::exception_ptr exception;
    };

    Course() = default;
    Course(Course &&other) noexcept : handle_(std::exchange(other.handle_, {})) {}
    Course &operator=(Course &&other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    Course(const Course &) = delete;
    Course &operator=(const Course &) = delete;
    ~Course() {
        if (handle_) {
            handle_.destroy();
        }
    }

    [[nodiscard]] std::coroutine_handle<promise_type> handle() const { return handle_; }

    static bool await_ready() { return false; }
    std::coroutine_handle<> await_suspend(std::coroutine_handle<> awaiter) {
        handle_.promise().awaiter = awaiter;
        return handle_;
    }
    /// Its result, or what was thrown in it.
    Result await_resume() {
        if (const std::exception_ptr exception = handle_.promise().exception) {
            std::rethrow_exception(exception);
        }
        return handle_.promise().take();
    }

private:
    explicit Course(std::coroutine_handle<promise_type> handle) : handle_(handle) {}

    std::coroutine_handle<promise_type> handle_;
};

/// What is shown at present, and the course that waits for its frame.
class Frames {
public:
    Frames() = default;
    ~Frames() = default;
    Frames(const Frames &) = delete;
    Frames &operator=(const Frames &) = delete;

    class Next {
    public:
        explicit Next(Frames &frames) : frames_(frames) {}
        static bool await_ready() { return false; }
        void await_suspend(std::coroutine_handle<> course) { frames_.waiting_ = course; }
        SittingFrame await_resume() { return std::move(frames_.frame_); }

    private:
        Frames &frames_;
    };

    class UntilEnd {
    public:
        UntilEnd(Frames &frames, Course<> course) : frames_(frames), course_(std::move(course)) {}
        UntilEnd(const UntilEnd &) = delete;
        UntilEnd &operator=(const UntilEnd &) = delete;
        ~UntilEnd() = default;
        static bool await_ready() { return false; }
        std::coroutine_handle<> await_suspend(std::coroutine_handle<> awaiter) {
            outer_ = std::exchange(frames_.innermost_, this);
            awaiter_ = awaiter;
            return course_->await_suspend(awaiter);
        }
        /// Whether it came to its own end.
        bool await_resume() {
            frames_.innermost_ = outer_;
            if (course_) {
                course_->await_resume();
            }
            return course_.has_value();
        }

    private:
        friend class Frames;
        Frames &frames_;
        std::optional<Course<>> course_; ///< nothing: it was ended
        std::coroutine_handle<> awaiter_;
        UntilEnd *outer_ = nullptr;
    };

    /// Up to the first picture.
    void start(Course<> course) {
        course_ = std::move(course);
        go_on(course_.handle());
    }
    /// To be awaited at once.
    [[nodiscard]] Next show(ParticipantPicture picture) {
        picture_ = std::move(picture);
        return Next(*this);
    }
    [[nodiscard]] UntilEnd until_end(Course<> course) { return {*this, std::move(course)}; }

    [[nodiscard]] const ParticipantPicture &picture() const { return picture_; }
    /// @pre it was started
    [[nodiscard]] bool is_over() const { return course_.handle().done(); }

    /// Goes on to the next picture, or to the end. Throws what the course does. @pre it is not over
    void resume(SittingFrame frame) {
        frame_ = std::move(frame);
        go_on(waiting_);
    }
    /// Ends the innermost course that has to be over then, and goes on after it.
    void end() {
        SPRINGDRIVE_ASSERT(innermost_ != nullptr); // all that is shown is in such a course
        innermost_->course_.reset();
        go_on(innermost_->awaiter_);
    }

private:
    void go_on(std::coroutine_handle<> course) {
        course.resume();
        if (is_over()) {
            course_.await_resume();
        }
    }

    ParticipantPicture picture_;
    SittingFrame frame_;
    std::coroutine_handle<> waiting_;
    UntilEnd *innermost_ = nullptr;
    Course<> course_;
};

/// Shows all of a Sitting, or what is resumed like one.
template <typename Activity, typename ItsWindow>
void show_to_end(Activity &activity, ItsWindow &window) {
    activity.start();
    while (!activity.is_over()) {
        activity.resume([&] { return window.show(activity.picture(), activity.state()); });
    }
}

} // namespace springdrive::app::study_screen
