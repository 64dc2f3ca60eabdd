// Something that takes many frames, as a coroutine that awaits the next frame:
//
//   Resumable<> wait(Frames &frames) { StudySessionFrame frame = co_await frames.show(picture); ...
//   }
//
//   what shows frames ──frame──► Frames::resume ──► who awaits it ──► next picture
//
// Resumables await each other. `Frames::end` ends the innermost one that is awaited as
// `frames.until_end(resumable)`: it is destroyed where it waits, with all that it has on its stack.
// What they take by reference must be a variable of who awaits them: GCC 12 destroys some
// temporaries twice.
#pragma once

#include "app/stage/frame_loop.h"
#include "app/study/participant/participant_picture.h"
#include "app/study/session/study_session_state.h"
#include "base/assertions.h"

#include <coroutine>
#include <exception>
#include <optional>
#include <utility>

namespace springdrive::app::study_screen {

template <typename Result> struct ResumableResult {
    std::optional<Result> result;

    void return_value(Result value) { result.emplace(std::move(value)); }
    Result take() { return *std::move(result); }
};
template <> struct ResumableResult<void> {
    void return_void() {}
    void take() {}
};

/// Runs when it is awaited, or started by Frames.
template <typename Result = void> class Resumable {
public:
    struct promise_type : ResumableResult<Result> {
        /// Goes on with whoever awaits it.
        struct AtEnd {
            static bool await_ready() noexcept { return false; }
            static std::coroutine_handle<>
            await_suspend(std::coroutine_handle<promise_type> ended) noexcept {
                return ended.promise().awaiter;
            }
            static void await_resume() noexcept {}
        };

        Resumable get_return_object() {
            return Resumable(std::coroutine_handle<promise_type>::from_promise(*this));
        }
        static std::suspend_always initial_suspend() { return {}; }
        static AtEnd final_suspend() noexcept { return {}; }
        void unhandled_exception() { exception = std::current_exception(); }

        std::coroutine_handle<> awaiter = std::noop_coroutine();
        std::exception_ptr exception;
    };

    Resumable() = default;
    Resumable(Resumable &&other) noexcept : handle_(std::exchange(other.handle_, {})) {}
    Resumable &operator=(Resumable &&other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    Resumable(const Resumable &) = delete;
    Resumable &operator=(const Resumable &) = delete;
    ~Resumable() {
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
    explicit Resumable(std::coroutine_handle<promise_type> handle) : handle_(handle) {}

    std::coroutine_handle<promise_type> handle_;
};

/// What is shown at present, and what waits for its frame.
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
        void await_suspend(std::coroutine_handle<> waiting) { frames_.waiting_ = waiting; }
        StudySessionFrame await_resume() { return std::move(frames_.frame_); }

    private:
        Frames &frames_;
    };

    class UntilEnd {
    public:
        UntilEnd(Frames &frames, Resumable<> resumable)
            : frames_(frames), resumable_(std::move(resumable)) {}
        UntilEnd(const UntilEnd &) = delete;
        UntilEnd &operator=(const UntilEnd &) = delete;
        ~UntilEnd() = default;
        static bool await_ready() { return false; }
        std::coroutine_handle<> await_suspend(std::coroutine_handle<> awaiter) {
            outer_ = std::exchange(frames_.innermost_, this);
            awaiter_ = awaiter;
            return resumable_->await_suspend(awaiter);
        }
        /// Whether it came to its own end.
        bool await_resume() {
            frames_.innermost_ = outer_;
            if (resumable_) {
                resumable_->await_resume();
            }
            return resumable_.has_value();
        }

    private:
        friend class Frames;
        Frames &frames_;
        std::optional<Resumable<>> resumable_; ///< nothing: it was ended
        std::coroutine_handle<> awaiter_;
        UntilEnd *outer_ = nullptr;
    };

    /// Up to the first picture.
    void start(Resumable<> whole) {
        whole_ = std::move(whole);
        go_on(whole_.handle());
    }
    /// To be awaited at once.
    [[nodiscard]] Next show(ParticipantPicture picture) {
        picture_ = std::move(picture);
        return Next(*this);
    }
    [[nodiscard]] UntilEnd until_end(Resumable<> resumable) {
        return {*this, std::move(resumable)};
    }

    [[nodiscard]] const ParticipantPicture &picture() const { return picture_; }
    /// @pre it was started
    [[nodiscard]] bool is_over() const { return whole_.handle().done(); }

    /// Goes on to the next picture, or to the end. Throws what is thrown there. @pre it is not over
    void resume(StudySessionFrame frame) {
        frame_ = std::move(frame);
        go_on(waiting_);
    }
    /// Ends the innermost one that has to be over then, and goes on after it.
    void end() {
        SPRINGDRIVE_ASSERT(innermost_ != nullptr); // all that is shown is in such a one
        innermost_->resumable_.reset();
        go_on(innermost_->awaiter_);
    }

private:
    void go_on(std::coroutine_handle<> waiting) {
        waiting.resume();
        if (is_over()) {
            whole_.await_resume();
        }
    }

    ParticipantPicture picture_;
    StudySessionFrame frame_;
    std::coroutine_handle<> waiting_;
    UntilEnd *innermost_ = nullptr;
    Resumable<> whole_;
};

/// A session, or visits, frame by frame in the windows in which they take place.
/// @tparam Resumed  a StudySession, or what is resumed like one
/// @tparam Windows  such as StudyWindow
template <typename Resumed, typename Windows> class StudySessionActivity : public Activity {
public:
    /// Starts it. Both must outlive this.
    StudySessionActivity(Resumed &resumed, Windows &windows)
        : resumed_(resumed), windows_(windows) {
        resumed.start();
    }

    [[nodiscard]] bool is_over() const override { return resumed_.is_over(); }
    void draw() override { frame_ = windows_.show(resumed_.picture(), resumed_.state()); }
    void update() override { resumed_.resume(std::move(frame_)); }
    [[nodiscard]] ReportedWindow reported() const override { return windows_.reported(); }

private:
    Resumed &resumed_;
    Windows &windows_;
    StudySessionFrame frame_;
};

} // namespace springdrive::app::study_screen
