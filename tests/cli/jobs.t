#!/usr/bin/perl
# voronoid submit, jobs, wait, fetch and cancel against a daemon of our own; and which daemon commands ask.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use HTTP::Tiny;
use JSON::PP;
use Test::More;

my $folder = scratch();
my $http = HTTP::Tiny->new(timeout => 120);
my $in = spew("$folder/in.ply", sphere(2000));
my $bad = spew("$folder/bad.ply", "hello\n");
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2, '--jobs', 1);
my @there = ('--server', $daemon->{url});
my @request = ('-n', '0.3k', '--iterations', 4, '--polish', 5);
my @long = ('-n', 2000, '--iterations', 10000, '--delta', 0, '--polish', 0);
my $uuid = qr/[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}/;
my $none = '0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11';

# What a process has printed so far.
sub shown { return -e "$_[0]{folder}/out" ? slurp("$_[0]{folder}/out") : '' }
sub info { return decode_json($http->get("$daemon->{url}/v1/jobs/$_[0]")->{content}) }
sub submitted {
    my (undef, $stdout) = run(['submit', 'resample', $in, @_, @there]);
    chomp $stdout;
    return $stdout;
}

my ($code, $stdout, $stderr) = run(['submit', 'resample', $in, @request, '--name', 'first', @there]);
is "$code|$stderr", '0|', 'submit: all is well';
like $stdout, qr/\A$uuid\n\z/, 'the ID is all that is printed';
chomp(my $done = $stdout);
is info($done)->{processID}, 'resample', 'the daemon has the job';
is info($done)->{voronoid}{target}{points} // info($done)->{voronoid}{target}, 300, 'with its parameters';

subtest 'thousands in a query' => sub {
    my $answer = $http->post("$daemon->{url}/v1/resample?points=0.05k&iterations=1&polish=1", { content => slurp($in) });
    like $answer->{content}, qr/^element vertex 50$/m, 'are those of the command line';
    $answer = $http->post("$daemon->{url}/v1/resample?points=1.2345k", { content => slurp($in) });
    is $answer->{status}, 400, 'and refused as there';
    like decode_json($answer->{content})->{detail}, qr/\Apoints is 1\.2345k, which is 1234\.5, want a whole number from 1 to /, 'with why';
    is $http->post("$daemon->{url}/v1/processes/resample/execution", { content => '{"inputs":{"points":"10k"}}',
        headers => { 'Content-Type' => 'application/json' } })->{status} =~ /^4/ ? 1 : 0, 1, 'a string is no number in JSON';
};

subtest 'submit' => sub {
    my ($code, $stdout, $stderr) = run(['submit', 'inspect', $in, $bad, $in, '--json', @there]);
    is $code, 3, 'a refusal shows';
    like $stderr, qr{\Avoronoid: \Q$bad\E: [^\n]+\nvoronoid: submit inspect: 1 of 3 failed\n\z}, 'it is said, and counted';
    my @jobs = map { decode_json($_) } split /\n/, $stdout;
    is_deeply [map { $_->{processID} } @jobs], ['inspect', 'inspect'], 'the others are handed in, and told as the daemon does';
    my ($first, $second) = map { $_->{jobID} } @jobs;
    run(['wait', $first, $second, '-q', @there]);
    for my $case (
        [['submit'], qr/\Avoronoid: submit: write the name of a process after submit: resample, denoise, [^\n]+\n\z/],
        [['submit', $in], qr/write the name of a process after submit/], [['submit', 'health', $in], qr/name of a process after submit/],
        [['submit', 'resample', @request], qr/\Avoronoid: submit resample: no input/],
        [['submit', 'resample', $in], qr/points, ratio and spacing: none is given/],
        [['submit', 'resample', $in, @request, '-o', 'x'], qr/no option -o; see voronoid submit resample --help/],
    ) {
        my ($arguments, $why) = @$case;
        ($code, $stdout, $stderr) = run([@$arguments, @there]);
        is "$code|$stdout", '2|', "@$arguments: refused";
        like $stderr, $why, 'and why';
    }
    ($code, $stdout) = run(['submit', 'resample', '--help']);
    like $stdout, qr/\Ausage: voronoid submit resample IN\.\.\. .*--points VALUE/s, 'submit PROCESS has help of its own';
};

subtest 'wait' => sub {
    my ($code, $stdout, $stderr) = run(['wait', $done, @there]);
    is "$code|$stdout", '0|', 'a job that is successful';
    like $stderr, qr/\Avoronoid: $done: 300 points, delta 0\.\d{4} after [^\n]+\n\z/, 'its summary has its ID';
    my $id = submitted(@request, '--seed', 2);
    for my $when ('with --json', 'once more') {
        ($code, $stdout, $stderr) = run(['wait', $id, '--json', @there]);
        my @lines = map { decode_json($_) } split /\n/, $stdout;
        is "$code|$stderr", '0|', "$when: all is well";
        ok exists $lines[0]{iteration} && exists $lines[-1]{stopped}, "$when: records, then the report";
    }
    ($code, $stdout, $stderr) = run(['wait', $none, $id, '-q', @there]);
    is "$code|$stdout", '1|', 'a job that is not there fails';
    like $stderr, qr/\Avoronoid: $none: [^\n]*\nvoronoid: wait: 1 of 2 failed\n\z/, 'and the others are waited for';
    $id = submitted(@long);
    my $waiting = start(['wait', $id, '--json', @there]);
    await { shown($waiting) =~ /"iteration":[1-9]/ };
    kill 'INT', $waiting->{pid};
    ($code, undef, $stderr) = finish($waiting);
    is "$code|$stderr", "130|voronoid: $id: stopped waiting for the job; the job itself continues\n", '^C ends the waiting';
    is info($id)->{status}, 'running', 'and not the job';
    $waiting = start(['wait', $id, '--json', @there]);
    await { shown($waiting) =~ /"iteration":[1-9]/ };
    ($code, $stdout, $stderr) = run(['cancel', $id, @there]);
    is "$code|$stdout|$stderr", "0||voronoid: $id: dismissed\n", 'cancel dismisses it';
    my $stopped = submitted(@long, '--seed', 2);
    await { (info($stopped)->{voronoid} // {})->{metrics} };
    ($code, undef, $stderr) = run(['stop', $stopped, @there]);
    is "$code|$stderr", "0|voronoid: $stopped: the job will stop; its result is the best cloud so far\n", 'stop keeps the best';
    is((run(['wait', $stopped, '-q', @there]))[0], 0, 'and the job is successful');
    ($code, undef, $stderr) = finish($waiting);
    is "$code|$stderr", "4|voronoid: $id: the job was dismissed\n", 'which ends the waiting as it should';
    my $line = spew("$folder/line.ply", "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
        . "property float z\nend_header\n" . join('', map {"$_ 0 0\n"} 1 .. 5));
    ($code, $stdout) = run(['submit', 'resample', $line, '-n', 3, @there]);
    chomp $stdout;
    ($code, undef, $stderr) = run(['wait', $stdout, @there]);
    is $code, 3, 'a job whose cloud is at fault ends as it would have here';
    like $stderr, qr/\Avoronoid: $stdout: The cloud has no surface[^\n]*\n\z/, 'and one line says why';
};

subtest 'jobs' => sub {
    my ($code, $stdout, $stderr) = run(['jobs', @there]);
    is "$code|$stderr", '0|', 'all is well';
    my ($head, @rows) = split /\n/, $stdout;
    like $head, qr/\AJOB +PROCESS +STATUS +PROGRESS +AGE +NAME\z/, 'a head';
    is scalar(@rows), scalar(@{ decode_json($http->get("$daemon->{url}/v1/jobs?limit=100")->{content})->{jobs} }), 'a line each';
    like $rows[-1], qr/\A$done  resample +successful +100 %  \d+ (?:s|min) +first\z/, 'the oldest comes last';
    (undef, $stdout) = run(['jobs', '-q', '--limit', 2, @there]);
    is scalar(split /\n/, $stdout), 2, '--limit';
    unlike $stdout, qr/[^0-9a-f\n-]/, 'and IDs alone with -q';
    (undef, $stdout) = run(['jobs', '--status', 'dismissed,failed', '--json', @there]);
    is_deeply [sort map { decode_json($_)->{status} } split /\n/, $stdout], ['dismissed', 'failed'], '--status';
    (undef, $stdout) = run(['jobs', '--json', $done, @there]);
    is decode_json($stdout)->{jobID}, $done, 'one that is named';
    for my $case (
        [['--limit', 0], qr/--limit is "0", want a whole number from 1 to 10000/], [['--limit', '2x'], qr/--limit is "2x"/],
        [['--status', 'lost'], qr/status|lost/], [['--status', 'a&b'], qr/status is "a&b", want some of accepted,/],
        [['x'], qr/"x" is not a job, want an ID such as/], [['../jobs'], qr/is not a job/], [["$done-"], qr/is not a job/], [[''], qr/"" is not a job/],
    ) {
        my ($arguments, $why) = @$case;
        ($code, undef, $stderr) = run(['jobs', @$arguments, @there]);
        is $code, 2, "@$arguments: refused";
        like $stderr, $why, 'and why';
    }
};

subtest 'the beginning of an ID' => sub {
    my @all = split /\n/, (run(['jobs', '-q', '--limit', 1000, @there]))[1];
    my ($length) = grep { my $begin = substr $done, 0, $_; 1 == grep {/^$begin/} @all } 1 .. 36;
    my ($only, $several) = map { substr $done, 0, $_ } $length, $length - 1;
    my ($code, $stdout, $stderr) = run(['jobs', '-q', $only, @there]);
    is "$code|$stdout|$stderr", "0|$done\n|", 'is enough where no other job has it';
    ($code, undef, $stderr) = run(['cancel', $only, @there]);
    is "$code|$stderr", "1|voronoid: $done: has already ended: successful\n", 'and messages have the whole';
    ($code, undef, $stderr) = run(['stop', $several, @there]);
    is $code, 2, 'one that several have is refused';
    my @like = grep {/^$several/} @all;
    is $stderr, "voronoid: $several: " . @like . ' jobs begin with this: ' . join(', ', @like[0 .. (@like > 5 ? 4 : $#like)])
        . (@like > 5 ? ' and ' . (@like - 5) . ' more' : '') . "\n", 'and they are named, at most five';
    ($code, undef, $stderr) = run(['fetch', 'ffff', '-fo', '-', @there]);
    is "$code|$stderr", "1|voronoid: ffff: no such job; voronoid jobs lists all jobs\n", 'and one of none';
};

subtest 'pages' => sub {
    my $many = 105;
    my $other = daemon("$folder/many", '127.0.0.1:0', '--threads', 1);
    my $small = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        . "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
    $http->post("$other->{url}/v1/inspect", { content => $small, headers => { Prefer => 'respond-async' } }) for 1 .. $many;
    my (undef, $stdout) = run(['jobs', '-q', '--limit', 10000, '--server', $other->{url}]);
    my %seen = map { $_ => 1 } split /\n/, $stdout;
    is scalar(keys %seen), $many, 'a list longer than a page is told whole, each job once';
    (undef, $stdout) = run(['jobs', '-q', '--limit', 102, '--server', $other->{url}]);
    is scalar(split /\n/, $stdout), 102, 'or as much of it as is asked for';
    stop($other, 'KILL');
};

subtest 'fetch' => sub {
    my $out = "$folder/out";
    my ($code, $stdout, $stderr) = run(['fetch', $done, '-fo', "$folder/x.ply", @there]);
    is "$code|$stdout", '0|', 'into a file';
    like $stderr, qr{\Avoronoid: \Q$folder\E/x\.ply: \d+ bytes\n\z}, 'which is told';
    run(['resample', $in, @request, '-q', '-fo', "$folder/here.ply"]);
    ok slurp("$folder/x.ply") eq slurp("$folder/here.ply"), 'the main result, as it is made here';
    ($code, $stdout, $stderr) = run(['fetch', $done, '--result', 'report', '-fo', '-', '-q', @there]);
    is decode_json($stdout)->{points}{out}, 300, 'another result to stdout';
    is "$code|$stderr", '0|', 'and nothing else';
    my ($inspected, $other) = map { $_->{jobID} } grep { $_->{processID} eq 'inspect' } map { decode_json($_) }
        split /\n/, (run(['jobs', '--json', '--status', 'successful', @there]))[1];
    ($code, $stdout, $stderr) = run(['fetch', $done, $inspected, $other, '--json', '-fo', "$out/", @there]);
    is "$code|$stderr", '0|', 'all results of several into a folder';
    my @told = map { decode_json($_) } split /\n/, $stdout;
    is_deeply [map { $_->{file} } grep { $_->{jobID} eq $done } @told], ["$out/first.resample.ply", "$out/first.report.json"],
        'each in a file with the name of its job';
    is_deeply [map { $_->{file} } grep { $_->{jobID} ne $done } @told], ["$out/in.inspect.json", "$out/$other.inspect.json"],
        'which is that of its input, and its ID where a job before it has the name';
    spew("$out/first.resample.ply", 'mine');
    ($code, undef, $stderr) = run(['fetch', $done, '-o', $out, @there]);
    is "$code|$stderr", "2|voronoid: $out/first.resample.ply: the file exists: use --force (-f) to overwrite it\n", 'nothing is overwritten silently';
    is slurp("$out/first.resample.ply"), 'mine', 'nor at all';
    run(['fetch', $done, '-fq', '-o', $out, @there]);
    is_deeply [map { -s $_->{file} } @told], [map { $_->{bytes} } @told], 'but with -f';
    is_deeply [sort split / /, leftovers($out)], [sort map { $_->{file} =~ s{.*/}{}r } @told], 'no others';
    for my $case (
        [[$done, $inspected, '-fo', 'x'], 2, qr/2 jobs need a folder for their results: give -o DIR/],
        [[$done, '--result', 'mesh', '-fo', '-'], 2, qr/$done: no result mesh, want cloud or report/],
        [[$none, '-fo', '-'], 1, qr/There is no such job/i], [[], 2, qr/no job: give its ID; see voronoid jobs/],
    ) {
        my ($arguments, $wanted, $why) = @$case;
        ($code, $stdout, $stderr) = run(['fetch', @$arguments, @there]);
        is "$code|$stdout", "$wanted|", "fetch @$arguments: refused";
        like $stderr, $why, 'and why';
    }
};

subtest 'cancel' => sub {
    my ($first, $second) = map { submitted(@long) } 1, 2;
    my ($code, $stdout, $stderr) = run(['cancel', $second, $done, $first, '--json', @there]);
    is $code, 1, 'one that is over counts as a failure';
    like $stderr, qr/\Avoronoid: $done: has already ended: successful\nvoronoid: cancel: 1 of 3 failed\n\z/, 'and is told';
    is_deeply [map { decode_json($_)->{status} } split /\n/, $stdout], ['dismissed', 'dismissed'], 'the others are dismissed';
    is((run(['fetch', $done, '-q', '-fo', '/dev/null', @there]))[0], 0, 'it keeps its results');
    ($code, undef, $stderr) = run(['fetch', $first, '-fo', '-', @there]);
    is $code, 1, 'what was dismissed has none';
};

subtest 'which daemon is asked' => sub {
    my ($port) = $daemon->{address} =~ /(\d+)$/;
    for my $listen ($daemon->{address}, "0.0.0.0:$port", "localhost:$port") {
        my ($code) = run(['health'], env => { VORONOID_LISTEN => $listen });
        is $code, 0, "that of VORONOID_LISTEN=$listen";
    }
    is((run(['jobs', '-q'], env => { VORONOID_LISTEN => '127.0.0.1:1', VORONOID_SERVER => $daemon->{url} }))[0], 0,
        'VORONOID_SERVER wins over it');
    for my $listen ('8080', '127.0.0.1:0', '127.0.0.1:70000', ':8080') {
        my ($code, undef, $stderr) = run(['health'], env => { VORONOID_LISTEN => $listen });
        is $code, 2, "VORONOID_LISTEN=$listen is refused";
        like $stderr, qr/\Avoronoid: health: VORONOID_LISTEN is "\Q$listen\E", want HOST:PORT/, 'and named';
    }
    for my $command (['submit', 'inspect', $in], ['jobs'], ['wait', $none], ['fetch', $none], ['cancel', $none]) {
        my ($code, $stdout, $stderr) = run([@$command, '--server', 'http://127.0.0.1:1']);
        is "$code|$stdout", '5|', "$command->[0]: one that is not there is unreachable";
        like $stderr, qr{\Avoronoid: http://127\.0\.0\.1:1\S*: [^\n]+\n\z}, 'and one line says so';
    }
};

is((stop($daemon))[0], 0, 'the daemon ends well');
done_testing;
