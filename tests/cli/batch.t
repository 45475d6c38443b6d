#!/usr/bin/perl
# Several inputs and a folder: names, summaries, failures that do not stop the rest, refusals before any work.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use JSON::PP;
use Test::More;

my $folder = scratch();
my ($a, $b) = map { spew("$folder/$_.ply", sphere(60, ord)) } qw(a b);
mkdir "$folder/sub";
my $twin = spew("$folder/sub/a.ply", sphere(60, 9));
my $bad = spew("$folder/bad.ply", "hello\n");
my $out = "$folder/out";
my @request = ('-n', 20, '--iterations', 2, '--polish', 2);

# What a process has printed so far.
sub shown { return -e "$_[0]{folder}/out" ? slurp("$_[0]{folder}/out") : '' }
sub clear { unlink glob "$out/*"; rmdir $out }
sub files { return leftovers($out) }

# The bytes of a run of its own.
sub alone {
    my ($in, $name, @more) = @_;
    run(['resample', $in, @request, @more, '-q', '-fo', "$folder/$name"]);
    my $bytes = slurp("$folder/$name");
    unlink "$folder/$name";
    return $bytes;
}

my ($code, $stdout, $stderr) = run(['resample', '--iterations', 2, $a, '--polish=2', '-n20', '-fo', "$out/", '--', $b]);
is "$code|$stdout", '0|', 'two inputs, among options, into a folder that is made';
like $stderr, qr{\Avoronoid: \Q$out\E/a\.ply: 20 points, [^\n]+\nvoronoid: \Q$out\E/b\.ply: 20 points, [^\n]+\n\z}, 'a summary line each';
is files(), 'a.ply b.ply', 'results have the names of their inputs';
ok slurp("$out/a.ply") eq alone($a, 'x.ply'), 'and the bytes of a run of its own';
ok slurp("$out/b.ply") eq alone($b, 'x.ply'), 'the second as well';
clear();

($code, $stdout, $stderr) = run(['resample', $a, @request, '--format', 'drc', '-q', '-fo', "$out/"]);
is "$code|$stdout|$stderr", '0||', 'one input into a folder, quietly';
is files(), 'a.drc', 'a format that is asked for changes the suffix';
ok slurp("$out/a.drc") eq alone($a, 'x.drc'), 'and the bytes';
clear();

my $odd = spew("$folder/a.scan.1", slurp($a));
run(['resample', $odd, @request, '-q', '--format=drc', '-fo', "$out/"]);
is files(), 'a.scan.1.drc', 'a suffix of no format is kept, and another is put behind it';
clear();

($code, $stdout, $stderr) = run(['resample', $a, $bad, "$folder/no.ply", $b, @request, '-fo', "$out/"]);
is "$code|$stdout", '3|', 'the exit code is that of the first failure';
my @said = split /\n/, $stderr;
is scalar(@said), 5, 'a line for each, and one for all';
like $said[1], qr{\Avoronoid: \Q$bad\E: }, 'the first failure names its input';
like $said[2], qr{\Avoronoid: \Q$folder\E/no\.ply: cannot be read}, 'so does the second';
is $said[4], 'voronoid: resample: 2 of 4 failed', 'the last line counts';
is files(), 'a.ply b.ply', 'what is right is there, and nothing else';
($code) = run(['resample', "$folder/no.ply", $bad, @request, '-q', '-fo', "$out/"]);
is $code, 1, 'whichever it was';
clear();

($code, $stdout) = run(['resample', $a, $b, @request, '--json', '-fo', "$out/"]);
my @lines = map { decode_json($_) } split /\n/, $stdout;
is_deeply [grep { exists $_->{input} } @lines], [map { { input => "$folder/$_.ply", output => "$out/$_.ply" } } qw(a b)],
    'with --json a line names input and output';
is_deeply $lines[0], { input => $a, output => "$out/a.ply" }, 'before the lines of its run';
is scalar(grep { exists $_->{stopped} } @lines), 2, 'each run ends with its report';
clear();

($code, $stdout, $stderr) = run(['inspect', $a, $b, '-fo', "$out/"]);
is "$code|$stdout|$stderr", "0||voronoid: $out/a.json: written\nvoronoid: $out/b.json: written\n", 'documents have a line each';
is files(), 'a.json b.json', 'and are JSON';
is decode_json(slurp("$out/a.json"))->{points}{all}, 60, 'each of its cloud';
clear();

sub refused {
    my ($name, $arguments, $wanted, $line, $there) = @_;
    my ($got, $printed, $errors) = run($arguments);
    is "$got|$printed|$errors", "$wanted||voronoid: resample: $line\n", $name;
    is -e $out ? files() : '', $there // '', "$name: nothing is made";
}
refused 'equal names', ['resample', $a, $b, $twin, @request, '-fo', "$out/"], 2,
    "the results of $a and $twin would have the same file name, $out/a.ply";
my $drc = spew("$folder/b.drc", 'x');
refused 'names that a format makes equal', ['resample', $b, $drc, @request, '--format=ply', '-fo', "$out/"], 2,
    "the results of $b and $drc would have the same file name, $out/b.ply";
refused 'an input without a name', ['resample', $a, '-', @request, '-fo', "$out/"], 2, "- has no file name, so the result in $out/ cannot be named after it";
refused 'a name whose suffix no format has', ['resample', $a, $odd, @request, '-fo', "$out/"], 2,
    "the result of $odd cannot be written: the suffix of the output is .1, want one of .ply, .drc, or give --format";
refused 'a folder as an input', ['resample', $a, "$folder/sub/", @request, '-fo', "$out/"], 2,
    "$folder/sub/ has no file name, so the result in $out/ cannot be named after it";
refused 'a folder in one that is not there', ['resample', $a, $b, @request, '-fo', "$out/x/"], 1,
    "$out/x/ cannot be made: No such file or directory";

my $process = start(['resample', $a, $b, '-n', 60, '--iterations', 10000, '--seconds', 60, '--polish', 0, '--delta', 0, '--json', '-fo', "$out/"]);
await { shown($process) =~ /"iteration":[1-9]/ };
kill 'INT', $process->{pid};
($code, undef, $stderr) = finish($process);
like "$code|$stderr", qr/^130\|voronoid: stopping; the best result so far is written/, '^C ends them all';
is files(), 'a.ply', 'and keeps the best of the one that was running';
spew("$out/a.ply", 'old');
refused 'a result that exists', ['resample', $b, $a, @request, '-o', "$out/"], 2, "$out/a.ply: the file exists: use --force (-f) to overwrite it", 'a.ply';
clear();

# Frames of a sequence: each from the last result, with the attributes that all have.
my @frames = map {
    my ($name, @attributes) = @$_;
    my $frame = sphere(60, 1) =~ s/(?=end_header)/join '', map { "property int $_\n" } @attributes/er;
    my $row = 0;
    spew("$folder/$name.ply", $frame =~ s/(?<=[0-9])\n(?=-?[0-9]|\z)/(' ' . $row++) x @attributes . "\n"/ger);
} ['f1', 'depth', 'class'], ['f2', 'class', 'track'], ['f3', 'class', 'depth'];
my ($f1, $f2, $f3) = @frames;
($code, $stdout, $stderr) = run(['sequence', $f1, $bad, $f2, $f3, '-q', '-n', 40, '-fo', "$out/"]);
is "$code|$stdout", '3|', 'a frame that is damaged fails alone';
like $stderr, qr{\Avoronoid: sequence: not all frames have these attributes, so no result has them: depth\nvoronoid: \Q$bad\E: .*\nvoronoid: sequence: 1 of 4 failed\n\z},
    'and is named, as are the attributes that some frames do not have';
is files(), 'f1.ply f2.ply f3.ply', 'the others are there';
is_deeply [map { [slurp("$out/$_.ply") =~ /^property \w+ (\w+)$/mg] } qw(f1 f2 f3)], [([qw(x y z track class)]) x 3], 'each with what all have';
run(['resample', $f3, '-n', 40, '--previous', "$out/f2.ply", '-q', '-fo', "$folder/x.ply"]);
my @bytes = map { slurp($_) =~ s/\A.*?end_header\n//sr } "$folder/x.ply", "$out/f3.ply";
is $bytes[0], $bytes[1], 'a frame that is sent alone has those of the result before';
clear();

my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);
($code, $stdout, $stderr) = run(['resample', $a, $bad, $b, @request, '-fo', "$out/", '--server', $daemon->{url}]);
is "$code|$stdout", '3|', 'a daemon does it as well, and refuses as well';
is files(), 'a.ply b.ply', 'what is right is there';
ok slurp("$out/b.ply") eq alone($b, 'x.ply'), 'with the same bytes';
is((stop($daemon))[0], 0, 'the daemon ends well');
done_testing;
