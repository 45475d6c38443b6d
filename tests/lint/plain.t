#!/usr/bin/perl
# Texts that people read are plain English: none has one of these phrases, which nobody says aloud. And what is written in
# two places by hand is the same in both: the version, the order of rooms, libraries and their doors, names of problems; and files that a reader is sent to are there.
use strict;
use warnings;
use Test::More;

# A phrase, and what to write instead.
my %better = (
    'told|tells' => 'reports, shows, says', 'asked for|asks for|is asked|are asked' => 'requested', 'whose' => 'of which, or two sentences',
    'whoever|whatever|whatsoever' => 'points that, any', 'nobody|somebody' => 'no client, another client',
    'what (?:[\w-]+ ){1,3}(?:is|are|was|were)\b(?! wrong)' => 'the noun that is meant', 'such [\w -]{1,40} that' => 'so ... that, a ... that',
    '(?<!there )is no (?!longer)[a-z]+' => 'is not a', 'those of them|of them that' => 'repeat the noun',
    'goes on|go on|going down' => 'continues, shutting down', 'taken for|comes of it|comes of the|comes to be' => 'counts as, results',
    'as many as may|than it may|it may have' => 'the limit, than allowed', 'not given:' => 'Default:', 'for want of' => 'because',
    'beforehand|thereof|herein|anew|hither|thence' => 'simpler', 'at a time that' => 'when', 'nonsense' => 'invalid',
    'stands? in for|stands for|stands in (?:the|a)\b' => 'replaces, is in', 'made of the' => 'made from', 'what came|what comes' => 'the noun',
    '(?:jobs?|runs?|it|they|what) (?:is|are) over' => 'has ended', 'under way' => 'in progress', 'left alone|be left' => 'unchanged', 'alike' => 'equally, similar',
);
# The string literals of a source, adjacent ones joined; of scripts also those in single and backward quotes.
sub literals {
    my ($path, $text) = @_;
    my $comment = qr{/\*.*?\*/|(?<!:)//[^\n]*}s;
    my $quoted = $path =~ /\.js$/ ? qr/"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'|`(?:[^`\\]|\\.)*`/ : qr/"(?:[^"\\\n]|\\.)*"/;
    $text =~ s/\\\n/ \n/g;
    my @found;
    my $next = 0;
    while ($text =~ /$comment|'(?:[^'\\\n]|\\.)'|($quoted)/g) {
        my ($literal, $begin) = ($1, $-[0]);
        next if !defined $literal;
        my $line = 1 + (substr($text, 0, $begin) =~ tr/\n//);
        if (@found && substr($text, $next, $begin - $next) =~ /^\s*$/) { $found[-1][1] .= substr $literal, 1, -1 }
        else { push @found, [$line, substr $literal, 1, -1] }
        $next = $begin + length $literal;
    }
    return grep { $_->[1] =~ /[a-z]+ [a-z]+ / } @found;
}

# Paragraphs of a document, without code; a table's rows and the texts of a YAML file are lines.
sub paragraphs {
    my ($path, $text) = @_;
    $text =~ s/^```.*?^```$/ "\n" x (($& =~ tr{\n}{}) + 1) /gmse;
    $text =~ s/`[^`\n]*`/`code`/g;
    my $line = 1;
    return map { my $at = $line; $line += tr/\n//; [$at, s/\s+/ /gr] } split /(?<=\n)(?=\n|\||- |#|\s+[\w'"\$-]+:)/, $text;
}

sub slurp { my ($path) = @_; open my $in, '<', $path or die "$path: $!\n"; local $/; return <$in> }

sub faults {
    my ($path, $text) = @_;
    my @texts = $path =~ /\.(?:[ch]|cc|js)$/ ? literals($path, $text) : paragraphs($path, $text);
    return map { my ($line, $said) = @$_;
        map { $said =~ /\b($_)/i ? "$path:$line: \"$1\" (better: $better{$_}) in: " . substr($said, 0, 150) : () } sort keys %better
    } @texts;
}

my @read = grep { -f && /\.(?:[ch]|cc|js|md|yaml|html|txt)$/ }
    split /\n/, `git ls-files -co --exclude-standard core proto server README.md ARCHITECTURE.md CHANGELOG.md openapi.yaml`;
cmp_ok scalar @read, '>', 100, 'there are texts to read';
is join("\n", map { faults($_, slurp($_)) } @read), '', 'every text is plain English';
is scalar(faults(@$_)), 1, "$_->[0] with such a phrase is seen" for ['x.md', "# A\n\nIt is told by the\ndaemon.\n"],
    ['x.c', "f(\"the key is \"\n  \"no number\");"], ['x.js', "say('the job goes on now');"];

my ($version) = slurp('Makefile') =~ /^VERSION := (\S+)$/m;
my %of = ('openapi.yaml' => qr/^  version: (\S+)$/m, 'CHANGELOG.md' => qr/^## (\d\S*)/m, 'docker/Dockerfile' => qr/^ARG VERSION=(\S+)$/m);
is +(slurp($_) =~ $of{$_})[0], $version, "$_ has the version of the Makefile" for sort keys %of;

my ($law, $text) = map { slurp($_) =~ s/\n +/ /gr } 'tests/lint/layers.t', 'ARCHITECTURE.md';
for my $part ('core', 'server') {
    my $order = join ' ', ($law =~ /^my \@$part = \((.*?)\);/m)[0] =~ /[\w ]+(?=')/g;
    is join(' ', ($text =~ /^- $part: (.*)$/m)[0] =~ /\w+/g), $order =~ s/\s+/ /gr, "ARCHITECTURE.md has the order of modules of $part";
}
my @doors = map { s/\\//gr =~ s/\$$//r } $law =~ /qr\{\^((?:core|proto|server)\/[^}]+)\}[,\]]/g;
is_deeply [grep { index($text, "`$_`") < 0 } @doors], [], 'and every door';
my @libraries = map { s/^lib//r } split ' ', (slurp('Makefile') =~ /^PKGS := (.*)$/m)[0];
is_deeply [grep { $text !~ /$_/i } @libraries], [], 'and every library';
my %problem = map { $_ => 1 } map { slurp($_) =~ /"([a-z]+(?:-[a-z]+)+)"/g } qw(core/base/status.h server/api/problem.h);
is_deeply [grep { !$problem{$_} } slurp('openapi.yaml') =~ /\(([a-wyz]\w+-[a-z-]+)[),;]/g], [], 'openapi.yaml names problems that exist';
# Figures of texts, and where the code or the image has them. A text has each once, and the same one.
sub figure {
    my ($path, $pattern) = @_;
    my @found = slurp($path) =~ /$pattern/;
    my ($factor, $word) = ({ million => 1e6, M => 1e6, K => 1024, KiB => 1024, minutes => 60 }, { four => 4, ten => 10 });
    my ($number, $unit) = @found == 1 ? $found[0] =~ /^([\d.,:]+|[a-z]+)\s*(\w*)$/i : ();
    return "$path has not one $pattern" if !defined $number;
    $number = $word->{ lc $number } // $number =~ tr/,//dr;
    return $factor->{$unit} ? $number * $factor->{$unit} : $number;
}
my ($help, $config, $tables) = ('server/cli/help', 'server/base/config.h', 'core/spec/tables.h');
my ($most, $usual) = ([$tables, qr/X\(RESAMPLE,[^\n]*\s0, (\d+), VOR/], [$tables, qr/X\(UPSAMPLE, RATIO, (\d+)\)/]);
my ($body, $in, $out) = ([$config, qr/"body-limit".*?"(\d+)G"/s], [$config, qr/"points-limit".*?"(\d+)"/s], [$tables, qr/X\(POINTS, .*?, 1, (\d+)/]);
my ($listen, $checks) = ([$config, qr/"listen", .*?"127\.0\.0\.1:(\d+)"/s], ['docker/Dockerfile', qr/ADMIN_LISTEN=127\.0\.0\.1:(\d+)/]);
my ($jobs, $rate) = map { ['server/base/keys.h', qr/QUOTA_${_}_DEFAULT = (\d+)/] } 'JOBS', 'RATE';
for (
    ['README.md', qr/(\d+) GiB/, $body], ['README.md', qr/and (\d+ million) points \(/, $in], ['README.md', qr/result\s+has\s+at\s+most\s+(\d+\s+million)/, $out],
    ["$help/limits.txt", qr/at most (\d+) GiB/, $body], ["$help/limits.txt", qr/inputs (\d+ million)/, $in], ["$help/limits.txt", qr/results (\d+ million)/, $out],
    ["$help/limits.txt", qr/take\s(\w+) times/, [$config, qr/take (\w+) times as long as\b/]], ["$help/choosing.txt", qr/at\s+most\s+(\d+)\s+times/, $most],
    ["$help/choosing.txt", qr/1\s+to\s+(\d+)\s+times/, $most], ["$help/choosing.txt", qr/default (\w+) times as many/, $usual], ['README.md', qr/\| (\w+) times as many/, $usual],
    [$tables, qr/default, (\w+) times/, $usual], ["$help/choosing.txt", qr/up to (\d+) iterations/, [$tables, qr/up to (\d+); up to 100 without/]],
    ["$help/keys.txt", qr/at most (\d+) jobs/, $jobs], ["$help/keys.txt", qr/(\d+)\s+requests\s+per/, $rate], ['server/cli/command.h', qr/wait or run \(default\W+(\d+)\)/, $jobs],
    ['server/cli/command.h', qr/started per second \(default (\d+)\)/, $rate], ["$help/keys.txt", qr/for\s+(\d+)\s+seconds/, ['server/api/tickets.h', qr/TICKET_SECONDS = (\d+)/]],
    ["$help/reports.txt", qr/more\s+than\s+([\d,]+)\s+input/, ['core/output/compare.h', qr/COMPARE_POINTS (\d+)/]], ["$help/reports.txt", qr/longest (\d+) loops/, ['core/report.h', qr/LOOPS_TOLD (\d+)/]],
    ["$help/reports.txt", qr/computed\s+at\s+(\d+)\s+places/, ['core/input/conditioning.h', qr/NEIGHBORS_PLACES = (\d+)/]], ["$help/data.txt", qr/once\s+in\s+(\w+\s+minutes)/, ['server/work/verify.c', qr/sound_seconds = (\d+)/]],
    ["$help/http.txt", qr/up to\s+(\d+) jobs/, ['openapi.yaml', qr/One stream for up to (\d+) jobs/]], ["$help/container.txt", qr/user (\d+)/, ['docker/Dockerfile', qr/^USER (\d+):/m]],
    ["$help/container.txt", qr/with status (\d+)/, ['server/cli/cli_log.h', qr/X\(USAGE, (\d+),/]], ['CHANGELOG.md', qr/with status (\d+);/, ['server/cli/cli_log.h', qr/X\(INTERRUPTED, (\d+),/]],
    ["$help/metrics.txt", qr/127\.0\.0\.1:(\d+)/, $checks], ['docker/compose.yaml', qr/127\.0\.0\.1:(\d+):/, $listen], ['docker/Dockerfile', qr/^EXPOSE (\d+)/m, $listen],
    ["$help/choosing.txt", qr/is ([\d.]+)\s+for\s+random/, ['README.md', qr/([\d.]+) for random/]], ["$help/reports.txt", qr/([\d.]+)\s+for\s+random/, ['README.md', qr/([\d.]+) for random/]],
    ["$help/proxies.txt", qr/every\s+(\d+)\s+seconds/, [$config, qr/"heartbeat", .*?"(\d+)"/s]], ["$help/limits.txt", qr/over\s+(\d+ KiB)/, ['server/http/state.h', qr/CONNECTION_BYTES = (\d+)/]],
    ['openapi.yaml', qr/at\s+most\s+(\d+)\s+parts/, ['proto/multipart.h', qr/PARTS_MAX = (\d+)/]], ['openapi.yaml', qr/boundary\s+at\s+most\s+(\d+)/, ['proto/multipart.h', qr/BOUNDARY_MAX = (\d+)/]],
    ['openapi.yaml', qr/field\s+may\s+have\s+at\s+most\s+(\d+\s+KiB)/, ['server/api/handlers/submit_form.c', qr/TEXT_MAX = (\d+)/]], ['openapi.yaml', qr/inflate\s+to\s+(\d+)\s+times\s+its/, ['proto/gzip.h', qr/RATIO_MAX = (\d+)/]],
    ["$help/choosing.txt", qr/qp 7 and 10,\s+the\s+file\s+needs\s+(\d+) %/, ['README.md', qr/file needs (\d+) %/]], ['core/report.h', qr/with ([\d.]+) turns/, ['core/input/loops.h', qr/HOLE_TURNS ([\d.]+)/]],
    ["$help/choosing.txt", qr/and (\d+) %\s+fewer\s+bytes/, ['README.md', qr/and (\d+) %\s+fewer/]], map({ [$_, qr/than\s+([\d.]+)\s+spacings/, ['core/metrics/cells.c', qr/WIDE ([\d.]+)/]] } "$help/reports.txt", 'core/report/parts.h'),
    ["$help/reports.txt", qr/\(([\d.]+)\s+is\s+the\s+best/, ['core/report/parts.h', qr/\(([\d.]+)\s+is\s+the\s+lowest/]],
    ['openapi.yaml', qr/at\s+most\s+([\d,]+)\s+points,\s+at\s+most\s+one/, ['server/jobs/preview.h', qr/PREVIEW_POINTS_MAX = (\d+)/]],
    ['server/cli/server.c', qr/LISTEN_DEFAULT "127\.0\.0\.1:(\d+)"/, $listen], ['openapi.yaml', qr{url: http://127\.0\.0\.1:(\d+)}, $listen],
) {
    my ($path, $pattern, $source) = @$_;
    is figure($path, $pattern), figure(@$source), "$path: $pattern is that of $source->[0]";
}
for (['README.md', 200], ['ARCHITECTURE.md', 150], ['CHANGELOG.md', 120]) {
    my ($path, $most) = @$_;
    my @lines = split /\n/, slurp($path);
    utf8::decode($_) for @lines;
    cmp_ok scalar @lines, '<=', $most, "$path has at most $most lines";
    is join("\n", grep { length > 120 } @lines), '', 'of at most 120 columns';
}
# Files that ARCHITECTURE.md sends a reader to: `room/{a,b}.h`.
sub missing {
    my ($text, @files) = @_;
    my @named = map { my $of = $_; $of =~ /\{(.*)\}/ ? map { $of =~ s/\{.*\}/$_/r } split /,/, $1 : $of } $text =~ m{`([\w./-]*(?:\{[\w,]+\})?\.[ch])`}g;
    my $all = join '', map { "/$_\n" } @files;
    return grep { index($all, "/$_\n") < 0 } @named;
}
is join(' ', missing(slurp('ARCHITECTURE.md'), split /\n/, `git ls-files`)), '', 'the files that a reader is sent to are there';
is join(' ', missing('`a/{x,y}.c` `z.h`', 'core/a/x.c')), 'a/y.c z.h', 'those that are not there are found';

done_testing;
