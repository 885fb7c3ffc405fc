"""Completion of options, choices, commands and steps, as bash, zsh and fish themselves do it."""
import os
import pathlib
import pty
import select
import shutil
import subprocess
import tempfile
import time
import unittest

BIN = pathlib.Path(os.environ["LAKE_BIN"])
PROGRAMS = ("lake", "lake-track", "lake-stroke")


def completion(program, shell):
    return subprocess.run([BIN / program, "--completion", shell], check=True, text=True, stdout=subprocess.PIPE).stdout


def needs(shell):
    return unittest.skipUnless(shutil.which(shell), f"{shell} is not installed")


class Completion(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def bash(self, *words):
        for program in PROGRAMS:
            (self.folder / program).write_text(completion(program, "bash"))
        script = f"""
            for file in {' '.join(PROGRAMS)}; do . {self.folder}/$file; done
            COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
            function=_$1; ${{function//-/_}}
            printf '%s\\n' "${{COMPREPLY[@]}}" """
        done = subprocess.run(["bash", "-c", script, "bash", *words], check=True, text=True, stdout=subprocess.PIPE, cwd=self.folder)
        return done.stdout.split()

    def fish(self, line):
        for program in PROGRAMS:
            (self.folder / f"{program}.fish").write_text(completion(program, "fish"))
        source = "; ".join(f"source {self.folder}/{program}.fish" for program in PROGRAMS)
        done = subprocess.run(["fish", "--no-config", "-c", f"{source}; complete -C '{line}'"], check=True, text=True, stdout=subprocess.PIPE,
                              env={**os.environ, "HOME": str(self.folder)}, cwd=self.folder)
        return [candidate.split("\t")[0] for candidate in done.stdout.splitlines()]

    def zsh(self, keys):
        """The arguments that a command gets of a line typed with these keys, \\t where Tab is pressed."""
        for program in PROGRAMS:
            (self.folder / f"_{program}").write_text(completion(program, "zsh"))
        setup = (f"fpath=({self.folder} $fpath); autoload -Uz compinit; compinit -u -d {self.folder}/dump; PS1='> '; unsetopt zle_bracketed_paste 2>/dev/null\n"
                 + "".join(f"{program}() {{ print -r -- \"GOT:$*:GOT\" > {self.folder}/got }}\n" for program in PROGRAMS))
        (self.folder / "got").unlink(missing_ok=True)
        (self.folder / ".zshrc").write_text(setup)
        child, terminal = pty.fork()
        if child == 0:
            os.environ.update(ZDOTDIR=str(self.folder), TERM="dumb")
            os.chdir(self.folder)
            os.execvp("zsh", ["zsh", "-i", "-d"])
        try:
            self.wait_for(terminal, b"> ")
            for key in keys:
                os.write(terminal, key.encode())
                if key == "\t":
                    self.wait_for(terminal, None)
            os.write(terminal, b"\n")
            deadline = time.monotonic() + 120
            while not (self.folder / "got").exists() or not (self.folder / "got").read_text().endswith(":GOT\n"):
                self.assertLess(time.monotonic(), deadline, "zsh ran no command")
                self.wait_for(terminal, None)
            return (self.folder / "got").read_text()[4:-5].split()
        finally:
            os.close(terminal)
            os.kill(child, 9)
            os.waitpid(child, 0)

    @staticmethod
    def wait_for(terminal, text):
        """Reads until the text has come; without one, until nothing has come for a quarter of a second."""
        seen = b""
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline and (text is None or text not in seen):
            if not select.select([terminal], [], [], 10 if text else 0.25)[0]:
                return
            seen += os.read(terminal, 4096)

    def test_bash(self):
        self.assertEqual(self.bash("lake-track", "--filter", "b"), ["butterworth"])
        self.assertEqual(self.bash("lake-track", "--no-o"), ["--no-overlay"])
        self.assertEqual(self.bash("lake-stroke", "cal"), ["calibrate"])
        self.assertEqual(self.bash("lake", "st"), ["stroke"])
        self.assertEqual(self.bash("lake", "track", "--filter", "b"), ["butterworth"])

    @needs("fish")
    def test_fish(self):
        self.assertEqual(self.fish("lake-track --filter b"), ["butterworth"])
        self.assertEqual(self.fish("lake-track --no-o"), ["--no-overlay"])
        self.assertEqual(self.fish("lake-stroke cal"), ["calibrate"])
        self.assertEqual(self.fish("lake st"), ["stroke"])
        self.assertEqual(self.fish("lake track --filter b"), ["butterworth"])

    @needs("zsh")
    def test_zsh(self):
        self.assertEqual(self.zsh("lake-track --filt\tb\t"), ["--filter=butterworth"])
        self.assertEqual(self.zsh("lake-stroke cal\t"), ["calibrate"])
        self.assertEqual(self.zsh("lake tra\t--no-ov\t"), ["track", "--no-overlay"])

    def test_each_program_completes_in_each_shell(self):
        programs = [path.name for path in sorted(BIN.glob("lake-*")) if os.access(path, os.X_OK)]
        self.assertGreater(len(programs), 10)
        for program in programs:
            for shell in ("zsh", "fish", "bash"):
                text = completion(program, shell)
                with self.subTest(program=program, shell=shell):
                    self.assertIn("version", text)
                    if shutil.which(shell):
                        self.assertEqual(subprocess.run([shell, "-n"], input=text, text=True, check=False).returncode, 0)

    def test_another_shell_is_wrong_usage(self):
        for program in ("lake", "lake-track"):
            done = subprocess.run([BIN / program, "--completion", "csh"], text=True, stderr=subprocess.PIPE, check=False)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))
            self.assertIn("bash, zsh or fish", done.stderr)


if __name__ == "__main__":
    unittest.main()
