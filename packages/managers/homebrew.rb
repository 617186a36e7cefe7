# A formula of Homebrew, for a tap: brew install OWNER/TAP/profidrive
class Profidrive < Formula
  desc "Emulates and judges PROFIBUS slaves and CANopen nodes"
  homepage "@REPOSITORY@"
  version "@VERSION@"
  license any_of: ["MIT", "Apache-2.0"]

  on_macos do
    on_arm do
      url "@RELEASE@/profidrive-@VERSION@-aarch64-apple-darwin.tgz"
      sha256 "@SHA256 aarch64-apple-darwin@"
    end
    on_intel do
      url "@RELEASE@/profidrive-@VERSION@-x86_64-apple-darwin.tgz"
      sha256 "@SHA256 x86_64-apple-darwin@"
    end
  end
  on_linux do
    on_arm do
      url "@RELEASE@/profidrive-@VERSION@-aarch64-unknown-linux-gnu.tgz"
      sha256 "@SHA256 aarch64-unknown-linux-gnu@"
    end
    on_intel do
      url "@RELEASE@/profidrive-@VERSION@-x86_64-unknown-linux-gnu.tgz"
      sha256 "@SHA256 x86_64-unknown-linux-gnu@"
    end
  end

  def install
    bin.install "profidrive"
    man1.install Dir["man/*.1"]
    bash_completion.install "completions/profidrive.bash" => "profidrive"
    zsh_completion.install "completions/profidrive.zsh" => "_profidrive"
    fish_completion.install "completions/profidrive.fish"
  end

  test do
    assert_match version.to_s, shell_output("#{bin}/profidrive --version")
  end
end
