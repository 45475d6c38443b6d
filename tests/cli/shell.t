#!/usr/bin/perl
# What is made of the tables for shells and readers: the manual, the completions, and how make installs them.
use strict;
use warnings;
use Cwd qw(getcwd);
use FindBin;
use lib $FindBin::Bin;
use Cli;
use Test::More;

my $folder = scratch();
my $in = spew("$folder/in.ply", sphere(50));
my $binary = $ENV{VORONOID} // 'build/release/voronoid';
$binary = getcwd() . "/$binary" unless $binary =~ m{^/};

sub printed {
    my ($code, $stdout, $stderr) = run([@_]);
    is "$code|$stderr", '0|', "voronoid @_: all is well";
    return $stdout;
}
sub has_program { return system("command -v $_[0] >/dev/null 2>&1") == 0 }

my ($list, $topics) = printed('--help') =~ /^Commands:\n(.*?)\n\n.*^Topics[^\n]*\n(.*?)\n\n/ms;
my @commands = $list =~ /^  ([a-z]+) +\S/mg;
cmp_ok scalar(@commands), '>', 10, 'there are commands';

# The options that the help of a command has: "--points", and with letters "-n".
sub options_of {
    my ($text) = @_;
    return sort map { grep { defined } @$_ } map { [m/^(?:(-\w), )?(--[A-Za-z-]+)/] } $text =~ /^  ((?:-\w, )?--.*)$/mg;
}
my %options = map { $_ => [options_of(printed($_, '--help'))] } grep { $_ ne 'serve' } @commands;
my @settings = sort { $a cmp $b } printed('serve', '--help') =~ /^  (--[a-z-]+)/mg;

subtest 'the topics' => sub {
    my @topics = map { [split ' ', $_, 2] } split /\n/, $topics;
    cmp_ok scalar(@topics), '>', 10, 'there are topics';
    is_deeply [sort map { s{.*/}{}r =~ s/[.]txt//r } glob 'server/cli/help/*.txt'], [sort map { $_->[0] } @topics], 'no text is left out';
    for my $topic (@topics) {
        my $text = printed('help', $topic->[0]);
        like $text, qr/\A\Q$topic->[1]\E\n\n *\S/, 'it begins with its title';
        is scalar(grep { length > 100 || /\s\z/ } split /\n/, $text), 0, 'no line is long, or ends with a blank';
        unlike $text, qr/^%/m, 'nothing is left of how it is written';
    }
    like printed('help', 'settings'), qr/^  \Q$_\E\b.*\n {6}\S/m, "help settings has $_" for @settings;
    # What stands in words as well is what the tables say.
    my ($serve, $resample, $upsample) = map { printed($_, '--help') } qw(serve resample upsample);
    my %says = (limits => qr/at most 1 GiB \(--body-limit\), inputs 50 million points\s+\(--points-limit\),\s+and results 10 million points\./, choosing => qr/default four times as many points [^.]*\. upsample\s+is\s+fast,\s+because\s+it\s+does\s+only\s+one\s+iteration/,
        keys => qr/at most 16 jobs that wait or run, and\s+may\s+send\s+10\s+requests\s+per\s+second/);
    like printed('help', $_), $says{$_}, "help $_ says what the tables have" for sort keys %says;
    like slurp('README.md'), qr/^- An upload has at most 1 GiB and 50 million points .* at most 10 million points\.$/m, 'and so does README.md';
    like $serve, qr/--$_->[0] \w+\n(?: {6}.*\n)*? {6}.*default $_->[1] /, "the tables: $_->[0] is $_->[1]"
        for ['body-limit', '1G'], ['points-limit', '50000000'];
    like $resample, qr/^ {6}1 to 10000000 points$/m, 'the tables: ten million points of a result';
    like $upsample, qr/--$_->[0] VALUE\n(?: {6}\S.*\n)*? {6}.*default $_->[1]$/m, "the tables: $_->[0] is $_->[1] of upsample" for [ratio => 4], [iterations => 1];
    like printed('key', '--help'), qr/that\s+wait\s+or\s+run\s+\(default\s+16\);\s+rate=N,[^(]*per\s+second\s+\(default\s+10\)/, 'the tables: quotas';
    like printed('help', 'metrics'), qr/^  voronoid_queue_jobs\n      gauge by state[.] /m, 'help metrics has what /metrics has';
    is printed('help', $_->[0]), printed('help', $_->[1]), "help $_->[0] is help $_->[1]" for ['backup', 'data'], ['nginx', 'proxies'];
};

subtest 'the manual' => sub {
    my %page = map { $_ => printed('--man', $_) } 1, 8;
    is((run(['--man', 5]))[0], 2, 'there is no other page');
    for my $section (sort keys %page) {
        like $page{$section}, qr/\A\.TH VORONOID $section /, "voronoid($section) begins as a page does";
        like $page{$section}, qr/^\.SH "$_"$/m, "and has $_" for qw(ENVIRONMENT FILES);
        is scalar(grep { length > 100 || /\s\z/ } split /\n/, $page{$section}), 0, 'no line is long, or ends with a blank';
        spew("$folder/voronoid.$section", $page{$section});
      SKIP: {
            skip 'mandoc: not on this machine', 1 unless has_program('mandoc');
            my @found = grep { !/missing date/ } `mandoc -T lint -W warning '$folder/voronoid.$section' 2>&1`;
            is "@found", '', 'mandoc finds nothing but that there is no date';
        }
      SKIP: {
            skip 'groff: not on this machine', 1 unless has_program('groff');
            is `groff -man -ww -T utf8 '$folder/voronoid.$section' 2>&1 >/dev/null`, '', 'groff warns of nothing';
        }
    }
    my $plain = $page{1} =~ s/\\-/-/gr =~ s/\\f.//gr;
    for my $command (@commands) {
        like $plain, qr/^\.TP\n\Q$command\E\n\S/m, "it has the command $command";
        my @missing = grep { $plain !~ /^(?:-\w, )?\Q$_\E(?: |\[|$)/m } grep { /^--/ } @{ $options{$command} // [] };
        is "@missing", '', "and every option of $command";
    }
    like $plain, qr/^\.TP\n$_\n\S/m, "and exit status $_" for 0 .. 5, 130;
    my $daemon = $page{8} =~ s/\\-/-/gr =~ s/\\f.//gr;
    is join(' ', grep { $daemon !~ /^\Q$_\E(?: |$)/m } @settings), '', 'the other page has every setting';
    like $daemon, qr/^\.TP\n$_\n\S/m, "and exit status $_" for 0, 1, 2, 75;
};

my $bash = spew("$folder/voronoid.bash", printed('--completion', 'bash'));
my $zsh = spew("$folder/_voronoid", printed('--completion', 'zsh'));
my $fish = spew("$folder/voronoid.fish", printed('--completion', 'fish'));
is((run(['--completion', 'csh']))[0], 2, 'no completion for a shell that is not known');
mkdir "$folder/bin" and symlink $binary, "$folder/bin/voronoid" or die;

# What a shell offers behind these words, the last of which is being written. bash takes words apart at each =.
sub bash {
    my @words = @_;
    my $list = join ' ', map { "'$_'" } $binary, @words;
    return "source '$bash'; COMP_WORDS=($list); COMP_CWORD=" . @words . '; _voronoid; printf "%s\n" "${COMPREPLY[@]}"';
}
sub fish { return "source '$fish'; complete -C 'voronoid @_'" }
sub offered {
    my ($shell, @words) = @_;
    local $ENV{PATH} = "$folder/bin:$ENV{PATH}";
    my @command = $shell eq 'bash' ? ('bash', '--norc', '-c', bash(@words)) : ('fish', '--no-config', '-c', fish(@words));
    open my $pipe, '-|', 'sh', '-c', 'cd "$0" && exec "$@"', $folder, @command or die "$shell: $!";
    my @offered = map { chomp; s/\t.*//r } <$pipe>;
    close $pipe;
    return join ' ', sort grep { length } @offered;
}

for my $shell ('bash', 'fish') {
    subtest $shell => sub {
        plan skip_all => "$shell: not on this machine" unless has_program($shell);
        is system($shell, '-n', $shell eq 'bash' ? $bash : $fish), 0, 'it can be read';
        my $also = $shell eq 'bash' ? [qw(--help --version --completion --man)] : [];
        is offered($shell, ''), join(' ', sort @commands, 'help', @$also), 'the first word is a command';
        for my $command (sort grep { $_ ne 'submit' } keys %options) {
            my $begin = $shell eq 'bash' ? '-' : '--'; # fish keeps letters apart
            is offered($shell, $command, $begin), join(' ', grep {/^$begin/} @{ $options{$command} }), "$command: the options of its help";
        }
        is offered($shell, 'serve', '--'), join(' ', sort '--help', @settings), 'serve: its settings';
        for my $case (
            [['resa'], 'resample', 'the beginning of a command'], [['submit', 'up'], 'upsample', 'submit wants a process'],
            [['submit', 'heal'], '', 'not any command'], [['submit', 'inspect', '--in'], '--intrinsic --invalid', 'and then takes its parameters'],
            [['resample', '--order', ''], 'progressive spatial', 'a choice has words'],
            [['resample', '--filters', 'mls,o'], 'mls,outliers', 'a list goes on behind a comma'],
            [['resample', '--neighbors', ''], 'auto', 'a number may have a word'], [['resample', '-n', ''], '', 'or none, and then no file is offered'],
            [['jobs', '--status', 'acc'], 'accepted', 'a status'], [['fetch', '--result', 're'], 'report', 'a result'],
            [['serve', '--log-level', 'd'], 'debug', 'a setting'], [['resample', 'in'], 'in.ply', 'an operand is a file'],
            [['resample', '-fo', 'in'], 'in.ply', 'so is an output'], [['measure', '--reference', 'in'], 'in.ply', 'and another input'],
            [['resample', '--quiet', 'in'], 'in.ply', 'a flag is followed by an operand'], [['help', 'mea'], 'measure', 'help wants a command'],
            $shell eq 'fish' ? [['resample', '--order=p'], '--order=progressive', 'also behind a =']
            : ([['resample', '--order', '=', 'p'], 'progressive', 'also behind a ='], [['resample', '--order', '='], 'progressive spatial', 'right behind it']),
        ) {
            my ($words, $wanted, $name) = @$case;
            is offered($shell, @$words), $wanted, $name;
        }
        my $daemon = daemon("$folder/$shell.data", '127.0.0.1:0', '--threads', 1);
        local $ENV{VORONOID_SERVER} = $daemon->{url};
        my (undef, $id) = run(['submit', 'inspect', $in]);
        chomp $id;
        is offered($shell, 'wait', substr $id, 0, 8), $id, 'wait wants a job of the daemon';
        stop($daemon);
    };
}
SKIP: {
    skip 'shellcheck: not on this machine', 1 unless has_program('shellcheck');
    is `shellcheck '$bash'`, '', 'shellcheck finds nothing';
}

subtest 'zsh' => sub {
    my $text = slurp($zsh);
    like $text, qr/\A#compdef voronoid\n/, 'zsh knows what it completes';
    for my $command (sort keys %options) {
        my ($block) = $text =~ /^  '$command'\)\n(.*?)^    ;;$/ms;
        my @missing = grep { $block !~ /(?<![\w-])\Q$_\E(?![\w-])/ } @{ $options{$command} };
        is "@missing", '', "$command: the options of its help";
    }
  SKIP: {
        skip 'zsh: not on this machine', 1 unless has_program('zsh');
        is system('zsh', '-n', $zsh), 0, 'zsh can read it';
    }
};

subtest 'make install' => sub {
    my ($config) = $binary =~ m{/build/(\w+)/voronoid\z} or plan skip_all => 'the binary is not one of ours';
    my $root = "$folder/root";
    my $make = sub { return system("make -s config=$config $_[0] DESTDIR='$root' PREFIX=/opt/v >'$folder/make.log' 2>&1") };
    is $make->('install'), 0, 'ends well' or diag slurp("$folder/make.log");
    my %same = ('share/man/man1/voronoid.1' => "$folder/voronoid.1", 'share/man/man8/voronoid.8' => "$folder/voronoid.8",
        'share/bash-completion/completions/voronoid' => $bash, 'share/zsh/site-functions/_voronoid' => $zsh, 'share/fish/vendor_completions.d/voronoid.fish' => $fish,
        'share/doc/voronoid/LICENSE' => 'LICENSE');
    for my $path (sort keys %same) {
        ok slurp("$root/opt/v/$path") eq slurp($same{$path}), "$path is there";
    }
    my $unit = 'lib/systemd/system/voronoid.service';
    is slurp("$root/opt/v/$unit"), slurp('docker/voronoid.service') =~ s{/usr/local/bin/}{/opt/v/bin/}r, "$unit starts what is installed";
    @same{$unit, qw(bin/voronoid bin/.debug/voronoid.debug include/voronoid.h lib/pkgconfig/voronoid.pc lib/libvoronoid.a lib/libvoronoid.so.0)} = ();
    cmp_ok -s "$root/opt/v/bin/voronoid", '<', -s $binary, 'the binary is stripped';
    like scalar `readelf --string-dump=.gnu_debuglink '$root/opt/v/bin/voronoid'`, qr/voronoid\.debug/, 'and names its symbols';
    my @files = split /\n/, `cd '$root/opt/v' && find . -type f`;
    is scalar(@files), scalar(keys %same), 'and nothing else';
    ok -x "$root/opt/v/bin/voronoid", 'the binary can be run';
    is $make->('uninstall'), 0, 'uninstall ends well' or diag slurp("$folder/make.log");
    is `find '$root' -type f`, '', 'and leaves no file';
    ok !-e "$root/opt/v/share/doc/voronoid", 'nor a folder of our own';
};
done_testing;
