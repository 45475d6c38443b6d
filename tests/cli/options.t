#!/usr/bin/perl
# What stands on the command line: help, version, and refusals in one line with their exit code.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use Test::More;

my $folder = scratch();
my $in = spew("$folder/in.ply", sphere(50));
my $out = "$folder/out.ply";
my @points = ('-n', 10);

sub refused {
    my ($name, $arguments, $code, $line, %with) = @_;
    my ($got, $stdout, $stderr) = run($arguments, %with);
    subtest $name => sub {
        is $got, $code, "the exit code is $code";
        is $stderr, "voronoid: $line\n", 'it says why in one line';
        is $stdout, '', 'nothing is printed';
        ok !-e $out, 'nothing is written';
    };
}

my ($code, $help, $errors) = run(['--help']);
is "$code$errors", '0', 'voronoid --help ends well';
unlike $help, qr/^.{101}/m, 'no line is long';
like $help, qr/^  \Q$_\E +\S/m, "the overview names $_" for qw(serve resample denoise upsample simplify measure inspect convert mesh restore register sequence submit jobs wait fetch cancel health);
like $help, qr/^  +$_  \S/m, "and the exit code $_" for 0 .. 5, 75, 130;

for my $command (qw(resample denoise upsample simplify measure inspect convert mesh restore register sequence submit jobs wait fetch cancel stop health key serve)) {
    ($code, $help, $errors) = run([$command, '--help']);
    is "$code$errors", '0', "voronoid $command --help ends well";
    like $help, qr/^usage: voronoid $command/, "it is the help of $command";
    unlike $help, qr/^.{101}|^ +--\w*[A-Z]/m, 'no line is long, and no option has capitals';
    my (undef, $same) = run(['help', $command]);
    is $same, $help, "voronoid help $command is the same";
    like $help, qr/^  +$_  \S/m, "it has the exit code $_" for $command eq 'serve' ? (0 .. 2, 75) : (0 .. 5, 130);
    like $help, qr/^Examples:\n(?:  \S.*\n)*  .*\bvoronoid \Q$command\E\b.*\n(?:  \S.*\n)*\z/m, 'and ends with examples';
}
my %options;
for my $command (qw(denoise upsample simplify resample)) {
    (undef, $help) = run([$command, '--help']);
    ($options{$command}) = $help =~ /\nOptions:\n(.*?)\n\n/s;
    is $options{$command}, $options{denoise}, "$command has the options of the others";
}
my (undef, $of_measure) = run(['measure', '--help']);
like $of_measure, qr/^usage: voronoid measure IN\.\.\. /, 'the help of measure names its operand';
like $of_measure, qr/^  --reference FILE\n/m, 'and its other input';
like $of_measure, qr/^  --peak VALUE\n(?: {6}\S[^\n]+\n)+      1e-30 to 1e\+30, in the unit of the cloud \| auto, default auto\n/m, 'and its parameter';
unlike $of_measure, qr/--(?:points|listen|seed|format)\b/, 'and nothing that it does not take';
unlike $help, qr/--(?:peak|reference)\b/, 'nor does that of resample';
like $help, qr/6 to 500 points \| auto, default auto/, 'it shows range, auto and default';
like $help, qr/--polish VALUE\n      Largest number [^\n]+\n(?: {6}\S[^\n]+\n)*      0 to 10000, default \d+\n/, 'it explains the polish';
like $help, qr/env:\s+VORONOID_SERVER/, 'it shows environment variables';

# Levels and presets.
my (undef, $of_resample) = run(['resample', '--help']);
my ($basic, $advanced) = $of_resample =~ /\nParameters of the request[^\n]*:\n(.*)\nAdvanced parameters[^\n]*:\n(.*)/s;
like $basic, qr/--points VALUE\n      Number of points of the result\. /, 'the help begins with basic parameters';
like $advanced, qr/--grading VALUE\n      How fast the distance between\b/, 'the advanced ones are under a heading of their own';
unlike $basic, qr/--grading/, 'and there alone';
like $of_resample, qr/\nPresets:\n  even .*: points=10000\n/, 'the help lists the presets';
unlike $of_measure, qr/preset/i, 'that of a process without any does not speak of them';
my $cloud = spew("$folder/thousand.ply", sphere(1000));
my @brief = ('--polish', 0, '--iterations', 2);
my %made;
for my $case (['preset', '--preset', 'quarter'], ['values', '--ratio', 0.25], ['mine', '--points', 30, '--preset', 'quarter']) {
    my ($name, @arguments) = @$case;
    is +(run(['simplify', $cloud, '-fo', "$folder/$name.ply", @brief, @arguments]))[0], 0, "simplify @arguments";
    $made{$name} = slurp("$folder/$name.ply");
}
is $made{preset}, $made{values}, 'a preset is its values';
like $made{mine}, qr/element vertex 30\n/, 'what is given besides wins, wherever it stands';
unlink $cloud, map { "$folder/$_.ply" } keys %made;
refused 'a preset that is none', ['resample', $in, '-fo', $out, '--preset', 'evn'], 2, 'resample: --preset is evn, want one of even, edges; did you mean even?';
refused 'a preset of another process', ['resample', $in, '-fo', $out, '--preset', 'mesh'], 2,
    'resample: --preset is mesh, want one of even, edges';
refused 'a preset where there is none', ['measure', $in, '--preset', 'even'], 2,
    'measure: no option --preset; see voronoid measure --help';

($code, $help) = run(['-V']);
my ($version) = slurp("$FindBin::Bin/../../Makefile") =~ /^VERSION := (\S+)$/m;
is $help, "voronoid $version\n", 'the version is one line, that of the Makefile';
is((run(['version']))[1], $help, 'voronoid version is the same');

($code, my $stdout, $errors) = run([]);
is "$code|$stdout", '2|', 'no command is an error';
like $errors, qr/\A(?:.{1,90}\n|\n){8,15}\z/, 'answered with how to begin';
is scalar(() = $errors =~ /^  voronoid (?:resample|inspect|serve)\b/mg), 3, 'by three commands';
refused 'an unknown command', ['resampel'], 2, 'resampel: no such command; did you mean resample?';
refused 'help of an unknown command', ['help', 'x'], 2, 'x: no such command or topic; see voronoid --help';
refused 'help of a misspelt topic', ['help', 'exmaples'], 2, 'exmaples: no such command or topic; did you mean examples?';
refused 'an unknown option', ['resample', $in, @points, '-fo', $out, '--pionts', 3], 2,
    'resample: no option --pionts; did you mean --points?';
refused 'an option that is nearly one of two words', ['mesh', '--max-aspct', 3], 2,
    'mesh: no option --max-aspct; did you mean --max-aspect?';
refused 'an unknown option with a value', ['resample', '--nope=1'], 2,
    'resample: no option --nope; see voronoid resample --help';
refused 'an unknown letter', ['resample', '-x'], 2,
    'resample: no option -x; see voronoid resample --help';
refused 'a letter that is not ASCII', ['resample', "-\xe9"], 2,
    'resample: no option -\\xe9; see voronoid resample --help';
refused 'a name cut too short', ['resample', $in, @points, '-fo', $out, '--po', 3], 2, 'resample: --po is ambiguous, want --points or --polish';
refused 'a name cut too short for both tables', ['resample', '--se=1'], 2, 'resample: --se is ambiguous, want --server or --seconds or --seed';
refused 'a name cut to nothing', ['resample', '--=1'], 2, 'resample: no option --; see voronoid resample --help';
refused 'a name cut short of a wrong value', ['resample', $in, @points, '-fo', $out, '--bound=open'], 2,
    'resample: boundary is "open", want one of keep, free, sites, fill';
refused 'an option of another command', ['measure', $in, '--listen', '127.0.0.1:1'], 2,
    'measure: no option --listen; see voronoid measure --help';
refused 'an input of another command', ['restore', $in, '-fo', $out, '--reference', $in], 2,
    'restore: no option --reference; see voronoid restore --help';
refused 'a parameter of another process', ['measure', $in, '--points', 5], 2,
    'measure: --points is an option of resample, denoise, upsample, simplify, mesh, not of measure';
refused 'a letter of another process', ['measure', $in, '-n', 5], 2, 'measure: no option -n; see voronoid measure --help';
refused 'a parameter of a command without a process', ['health', '--points', 5], 2,
    'health: no option --points; see voronoid health --help';
refused 'an option with a newline', ['resample', "--a\nb"], 2,
    'resample: no option --a\\x0ab; see voronoid resample --help';
my $bare = spew("$folder/zero.ply", "ply\nformat ascii 1.0\nelement vertex 5\n" . join('', map { "property float $_\n" } qw(x y z nx ny nz))
    . "end_header\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 0\n1 1 0 0 0 1\n2 1 0 0 nan 1\n");
refused 'normals that cannot be used', ['resample', $bare, '-n', 5, '-fo', $out, '--inputNormals', 'use'], 3,
    "$bare: inputNormals=use needs valid normals, but 2 of 5 normals are zero or not finite, the first at point 2";
unlink $bare;
refused 'no value', ['resample', $in, '-fo', $out, '-n'], 2, 'resample: -n needs a value';
refused 'no value behind other letters', ['resample', $in, '-fo', $out, '-qn'], 2, 'resample: -n needs a value';
refused 'no value of a long option', ['resample', $in, '-fo', $out, '--seed'], 2,
    'resample: --seed needs a value';
refused 'a value for a flag', ['resample', $in, @points, '-fo', $out, '--json=1'], 2,
    'resample: --json takes no value';
refused 'no input', ['resample', @points, '-fo', $out], 2,
    'resample: no input: give a file, or - for stdin';
refused 'two inputs and one file', ['resample', $in, $in, @points, '-fo', $out], 2,
    'resample: 2 inputs need a folder for their results: give -o DIR/';
refused 'two inputs and stdout', ['inspect', $in, $in], 2,
    'inspect: 2 inputs need a folder for their results: give -o DIR/';
refused 'an operand too many', ['health', 'x'], 2, 'health: x is one operand too many';
refused 'no output', ['resample', $in, @points], 2,
    'resample: no output: give -o FILE, or -o - for stdout';
refused 'no number of points', ['resample', $in, '-fo', $out], 2,
    'resample: give exactly one of the parameters points, ratio and spacing: none is given';
refused 'no number of points to simplify to', ['simplify', $in, '-fo', $out], 2,
    'simplify: give exactly one of the parameters points, ratio and spacing: none is given';
refused 'a ratio that makes fewer points', ['upsample', $in, '-fo', $out, '--ratio', '0.9'], 2,
    'upsample: ratio is 0.9, want a number from 1 to 16';
refused 'fewer points to upsample to', ['upsample', $in, '-fo', $out, '-n', 49], 3,
    "$in: points is 49, want 50 to 800: the result of upsample may have 1 to 16 times as many points as the input (50)";
refused 'more points to simplify to', ['simplify', $in, '-fo', $out, '-n', 51], 3,
    "$in: points is 51, want 1 to 50: simplify cannot give more points than the input has (50)";
refused 'too many points to denoise to', ['denoise', $in, '-fo', $out, '-n', 801], 3,
    "$in: points is 801, want 1 to 800: the result of denoise may have up to 16 times as many points as the input (50)";
refused 'points and ratio', ['resample', $in, '-fo', $out, @points, '--ratio', 2], 2,
    'resample: give exactly one of the parameters points, ratio and spacing, not 2';
refused 'a number of points out of range', ['resample', $in, '-fo', $out, '-n', 0], 2,
    'resample: points is 0, want a whole number from 1 to 10000000';
refused 'half a point in thousands', ['resample', $in, '-fo', $out, '-n', '1.2345k'], 2,
    'resample: points is 1.2345k, which is 1234.5, want a whole number from 1 to 10000000';
refused 'more millions than there may be', ['resample', $in, '-fo', $out, '--points=10.000001M'], 2,
    'resample: points is 10.000001M, which is 10000001, want a whole number from 1 to 10000000';
refused 'a number with a newline', ['resample', $in, '-fo', $out, '-n', "1\n"], 2,
    'resample: points is 1\\x0a, want a whole number from 1 to 10000000';
refused 'a wrong word', ['resample', $in, '-fo', $out, @points, '--boundary', 'open'], 2,
    'resample: boundary is "open", want one of keep, free, sites, fill';
refused 'a method of another process', ['upsample', $in, '-fo', $out, '--method', 'kmeans'], 2,
    'upsample: method is "kmeans", want one of cvt, wlop, ear, isotropic, insert';
refused 'too many threads', ['resample', $in, '-fo', $out, @points, '--threads', 257], 2,
    'resample: --threads is "257", want a whole number from 0 to 256';
refused 'threads by the environment', ['resample', $in, '-fo', $out, @points], 2,
    'resample: --threads is "two", want a whole number from 0 to 256', env => { VORONOID_THREADS => 'two' };
refused 'two clouds from one stdin', ['measure', '-', '--reference', '-'], 2,
    'measure: both clouds are given as - (stdin), but stdin has only one cloud: want a file for one of them';

refused 'a file that is not there', ['resample', "$folder/no.ply", @points, '-fo', $out], 1,
    "$folder/no.ply: cannot be read: No such file or directory";
refused 'a folder', ['resample', $folder, @points, '-fo', $out], 1,
    "$folder: cannot be read: Is a directory";
refused 'a folder to write into that is not there',
    ['resample', $in, @points, '-fo', "$folder/no/out.ply"], 1,
    "$folder/no/out.ply: cannot be written: No such file or directory";
refused 'a folder as output', ['resample', $in, @points, '-fo', $folder], 2,
    "resample: $in: the output is the input $in itself: give another output";

# getopt_long's ways of writing options.
my $plain = do { run(['resample', $in, @points, '--seed', 7, '-q', '-fo', $out]); slurp($out) };
for my $case (
    ['a value behind a letter', "-n10", '--seed=7', '-qfo', $out, $in], ['a value behind letters', '-qn10', "-fo$out", '--seed', 7, $in],
    ['names cut short', '--point', 10, '--see=7', '--qui', '--outp', $out, $in],
    ['operands last', '-q', '-n', 10, '--seed', 7, '-fo', $out, '--', $in],
    ['thousands', '-n', '0.01k', '--seed', '0.007k', '-q', '-fo', $out, $in], ['millions', '-n.00001M', '--seed=7', '-q', '-fo', $out, $in],
) {
    my ($name, @words) = @$case;
    unlink $out;
    my ($got, $stdout, $stderr) = run(['resample', @words], env => { POSIXLY_CORRECT => 1 });
    is "$got|$stdout|$stderr", '0||', "$name: all is well";
    ok slurp($out) eq $plain, "$name: the same bytes";
}
spew("$folder/-n.ply", slurp($in));
is((run(['resample', '--', "$folder/../" . ($folder =~ m{([^/]+)\z})[0] . '/-n.ply', '-n', 10, '-fo', $out]))[0], 2,
    'behind -- options are operands');
unlink $out, "$folder/-n.ply";

my ($subject, $message);
for my $case (
    ['an empty file', '', qr/./], ['no cloud', "hello world\n", qr/68 65 6c|hello/],
    ['half a header', "ply\nformat ascii 1.0\n", qr/./],
    ['too few points', "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
        . "property float y\nproperty float z\nend_header\n0 0 0\n", qr/./],
    ['a coordinate that is no number', sphere(3) =~ s/\S+ \S+ \S+\n\z/nan 0 0\n/r, qr/nan|NaN|finite/],
    ['points on a line', "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n"
        . "property float y\nproperty float z\nend_header\n" . join('', map {"$_ 0 0\n"} 1 .. 5), qr/./],
) {
    my ($name, $bytes, $why) = @$case;
    my $bad = spew("$folder/bad.ply", $bytes);
    my ($got, $stdout, $stderr) = run(['resample', $bad, @points, '-fo', $out]);
    is $got, 3, "$name is an input that is rejected";
    like $stderr, qr/\Avoronoid: \Q$bad\E: [^\n]+\n\z/, "$name is told in one line";
    like $stderr, $why, "$name is told by what it is";
    ok !-e $out, "$name leaves no output";
}
is leftovers($folder, 'in.ply', 'bad.ply'), '', 'no temporary file is left behind';

done_testing;
