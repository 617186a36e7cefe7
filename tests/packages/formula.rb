# Reads a formula as Homebrew does, on each system and processor, and installs from a folder:
#
#   formula.rb FORMULA FOLDER PREFIX    prints "SYSTEM PROCESSOR URL SHA256" for each; FOLDER is what an archive holds
require "fileutils"

# What a formula may say.
class Formula
  class << self
    attr_accessor :machine, :said, :test_block

    %i[desc homepage version license].each { |name| define_method(name) { |value| said[name] = value } }
    def url(value) = said[:url] = value
    def sha256(value) = said[:sha256] = value
    def on_macos = machine[0] == "macos" && yield
    def on_linux = machine[0] == "linux" && yield
    def on_arm = machine[1] == "arm" && yield
    def on_intel = machine[1] == "intel" && yield
    def test(&block) = self.test_block = block

    # A formula speaks when its class is made.
    def inherited(formula)
      super
      formula.machine = Formula.machine
      formula.said = {}
    end
  end

  Place = Struct.new(:path) do
    def install(*files)
      FileUtils.mkdir_p(path)
      files.flatten.each do |file|
        file.is_a?(Hash) ? file.each { |from, to| FileUtils.cp(from, "#{path}/#{to}") } : FileUtils.cp(file, path)
      end
    end

    def to_s = path
  end

  PLACES = {
    bin: "bin", man1: "share/man/man1", bash_completion: "etc/bash_completion.d",
    zsh_completion: "share/zsh/site-functions", fish_completion: "share/fish/vendor_completions.d"
  }.freeze
  PLACES.each { |name, place| define_method(name) { Place.new("#{PREFIX}/#{place}") } }
  def version = self.class.said[:version]
  def shell_output(command) = `#{command}`.tap { $?.success? || abort("#{command}: #{$?}") }
  def assert_match(wanted, text) = text.include?(wanted) || abort("#{wanted} is not in #{text}")
end

formula, folder, PREFIX = ARGV
%w[macos linux].product(%w[arm intel]).each do |machine|
  Formula.machine = machine
  Object.send(:remove_const, :Profidrive) if defined?(Profidrive)
  load formula
  puts [*machine, Profidrive.said[:url], Profidrive.said[:sha256]].join(" ")
end
made = Profidrive.new
Dir.chdir(folder) { made.install }
made.instance_exec(&Profidrive.test_block)
