#!/usr/bin/perl
# voronoid resample --server URL and voronoid health against a daemon of our own.
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
my $in = spew("$folder/in.ply", sphere(4000));
my $out = "$folder/out.ply";
my @request = ('-n', 500, '--iterations', 6);
my @long = ('-n', 4000, '--iterations', 10000);
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2, '--log-level', 'info');
my $url = $daemon->{url};

run(['resample', $in, @request, '-q', '-fo', "$folder/here.ply"]);
my $wanted = slurp("$folder/here.ply");

sub jobs { return decode_json($http->get("$_[0]/v1/jobs?limit=100")->{content})->{jobs} }

# The one job of a daemon that runs, once it has done some work.
sub running {
    my ($at) = @_;
    return await {
        my ($job) = grep { $_->{status} eq 'running' && $_->{voronoid}{metrics} } @{ jobs($at) };
        $job;
    };
}

subtest 'libraries are loaded by the commands that need them' => sub {
    for (['libcurl-gnutls.so.4', 'libcurl3-gnutls', 'health', '--server', $url], ['libflann.so.1.9', 'libflann1.9', 'measure', $in],
        ['libmicrohttpd.so.12', 'libmicrohttpd12', 'serve', '--listen', '127.0.0.1:0', '--data', "$folder/none"]) {
        my ($library, $package, @command) = @$_;
        my %env = (LD_LIBRARY_PATH => $folder);
        spew("$folder/$library", '');
        my ($code, undef, $stderr) = run(['convert', $in, '-q', '-fo', $out], env => \%env);
        is "$code|$stderr", '0|', 'others do not';
        ($code, undef, $stderr) = run(\@command, env => \%env);
        like "$code|$stderr", qr/\A1\|voronoid: .*\Q$library\E: file too short; it is in Debian's package \Q$package\E\n\z/, 'what is missing is said';
        unlink "$folder/$library", $out;
    }
};

subtest 'health' => sub {
    my ($code, $stdout, $stderr) = run(['health', '--server', $url]);
    is "$code|$stdout|$stderr", "0|$url: ready\n|", 'a daemon is ready';
    ($code) = run(['health', "--server=$url/"]);
    is $code, 0, 'a slash behind its URL does not matter';
    ($code) = run(['health'], env => { VORONOID_SERVER => $url });
    is $code, 0, 'the environment can name it';
    ($code, $stdout, $stderr) = run(['health', '--server', 'http://127.0.0.1:1']);
    is "$code|$stdout", '5|', 'one that is not there is unreachable';
    like $stderr, qr{\Avoronoid: http://127.0.0.1:1: [^\n]+\n\z}, 'and one line says so';
    ($code, $stdout, $stderr) = run(['health', '--server', 'file:///etc/passwd']);
    is "$code|$stdout", '5|', 'a file is no daemon';
};

subtest 'the same job far away' => sub {
    my ($code, $stdout, $stderr) = run(['resample', $in, @request, '-fo', $out, '--server', $url]);
    is $code, 0, 'all is well';
    is $stdout, '', 'stdout stays empty';
    like $stderr, qr/\Avoronoid: \Q$out\E: 500 points, delta 0\.\d{4} after 6 iterations(?: and \d+ polish steps)?, /,
        'one sentence says how it went';
    ok slurp($out) eq $wanted, 'the bytes are those of a run here';
    ($code, $stdout) = run(['resample', '-', @request, '-fo', '-', '-q', '--server', "$url/"], stdin => $in);
    ok $code == 0 && $stdout eq $wanted, 'also from stdin to stdout';
    ($code) = run(['resample', $in, @request, '-fo', $out, '-q'], env => { VORONOID_SERVER => $url });
    is scalar @{ jobs($url) }, 3, 'also by the environment';
    ($code) = run(['resample', $in, @request, '-fo', $out, '-q', '--server='], env => { VORONOID_SERVER => $url });
    is scalar @{ jobs($url) }, 3, 'an empty URL means here';
    is((stat $out)[7], length $wanted, 'and writes as much');
};

subtest 'the frames of a sequence' => sub {
    my @frames = ($in, spew("$folder/bad.ply", 'no cloud'), spew("$folder/in2.ply", sphere(3000, 7)));
    for (['here'], ['there', '--server', $url]) {
        my ($name, @server) = @$_;
        my ($code, undef, $stderr) = run(['sequence', @frames, @request, '-q', '-fo', "$folder/$name/", @server]);
        like "$code$stderr", qr{^3voronoid: \Q$frames[1]\E: .*\nvoronoid: sequence: 1 of 3 failed\n\z}, "$name: a damaged frame fails alone";
    }
    ok slurp("$folder/here/$_.ply") eq slurp("$folder/there/$_.ply"), "$_: the bytes are those of a run here" for qw(in in2);
    unlink @frames[1, 2], glob "$folder/{here,there}/*";
    rmdir "$folder/$_" for qw(here there);
};

subtest 'the same lines of JSON' => sub {
    my (undef, $here) = run(['resample', $in, @request, '--json', '-fo', "$folder/here.drc"]);
    my ($code, $there, $stderr) = run(['resample', $in, @request, '--json', '-fo', "$folder/there.drc", '--server', $url]);
    is "$code$stderr", '0', 'all is well';
    ok slurp("$folder/here.drc") eq slurp("$folder/there.drc"), 'the suffix says the format there too';
    my ($ours, $theirs) = map { [map { decode_json($_) } split /\n/] } $here, $there;
    my ($our_report, $their_report) = (pop @$ours, pop @$theirs);
    my %by_step; # the last step is told once more where gaps are narrowed after it
    push @{ $by_step{"$_->{iteration}+$_->{polish}"} }, { %$_, seconds => 0 } for @$ours;
    cmp_ok scalar @$theirs, '>=', 1, 'there are records';
    for my $record (@$theirs) {
        my $step = "$record->{iteration}+$record->{polish}";
        my ($same) = grep { $_->{best}{delta} == $record->{best}{delta} } @{ $by_step{$step} // [] };
        is_deeply { %$record, seconds => 0 }, $same, "record $step is the same";
    }
    for my $report ($our_report, $their_report) {
        delete @$report{qw(seconds memory_peak_bytes)};
        delete $_->{seconds} for @{ $report->{stages} };
    }
    is_deeply $their_report, $our_report, 'the report is the same';
};

subtest 'two clouds, as a form' => sub {
    my @pair = ("$folder/here.ply", '--reference', $in);
    my (undef, $here) = run(['measure', @pair]);
    my ($code, $there, $stderr) = run(['measure', @pair, '--server', $url]);
    is "$code$stderr", '0', 'measure can be done there';
    is $there, $here, 'and says the same';
    is +(run(['measure', '-', '--reference', $in, '--peak', 2, '--server', $url], stdin => $pair[0]))[1],
        (run(['measure', @pair, '--peak=2']))[1], 'also of stdin, and with a parameter';
    is +(run(['measure', $pair[0], '--server', $url]))[1], (run(['measure', $pair[0]]))[1], 'one cloud is the body';
    ($code, my $id, $stderr) = run(['submit', 'measure', @pair, '--server', $url]);
    is $code, 0, 'and submitted' or diag $stderr;
    ($code) = run(['wait', $id =~ /(\S+)/, '-q', '--server', $url]);
    is $code, 0, 'it ends well';
    my $bad = spew("$folder/bad.ply", "hello\n");
    ($code, my $stdout, $stderr) = run(['measure', $in, '--reference', $bad, '--server', $url]);
    is "$code$stdout", 3, 'a reference in no format is refused';
    like $stderr, qr/\Avoronoid: \Q$in\E: [^\n]*reference: the input begins with "hello[^\n]*\n\z/, 'and is the one that is named';
    ($code, $stdout, $stderr) = run(['measure', $in, '--reference', "$folder/no.ply", '--server', $url]);
    is "$code$stdout$stderr", "1voronoid: $folder/no.ply: cannot be read: No such file or directory\n", 'so is one that is not there';
    unlink $bad;
};

subtest 'refusals' => sub {
    unlink $out;
    my $bad = spew("$folder/bad.ply", "hello\n");
    my $empty = spew("$folder/empty.ply", '');
    for my $case (
        [$bad, 3, qr/The format of the data is not supported: [^\n]+/], [$empty, 3, qr/The cloud has no points: [^\n]+/],
        ["$folder/no.ply", 1, qr/cannot be read: No such file or directory/],
    ) {
        my ($path, $wanted, $why) = @$case;
        my ($code, $stdout, $stderr) = run(['resample', $path, '-n', 5, '-fo', $out, '--server', $url]);
        is $code, $wanted, "$path is refused with $wanted";
        like $stderr, qr/\Avoronoid: \Q$path\E: $why\n\z/, 'one line says why';
        is $stdout, '', 'nothing is printed';
    }
    my ($code, undef, $stderr) = run(['resample', $in, '-n', 100000, '-fo', $out, '--server', $url]);
    is $code, 3, 'more points than the cloud is good for are refused';
    like $stderr, qr/points is 100000, want 1 to 64000/, 'with the range';
    ($code, undef, $stderr) = run(['resample', $in, @request, '-fo', $out, '--server', 'http://127.0.0.1:1']);
    is $code, 5, 'a server that is not there is unreachable';
    like $stderr, qr{\Avoronoid: http://127.0.0.1:1: [^\n]+\n\z}, 'one line says so';
    ($code, undef, $stderr) = run(['resample', $in, @request, '-fo', $out, '--server', "$url/elsewhere"]);
    is $code, 1, 'a path that is not there is a failure';
    like $stderr, qr/\Avoronoid: \Q$in\E: There is nothing at this path[^\n]*\n\z/, 'one line says so';
    ok !-e $out, 'nothing is written';
    is leftovers($folder, qw(data none in.ply here.ply here.drc there.drc bad.ply empty.ply)), '', 'nothing is left behind';
};

subtest 'a signal' => sub {
    for my $case (['INT', 130], ['TERM', 4]) {
        my ($signal, $wanted) = @$case;
        my $process = start(['resample', $in, @long, '--json', '-fo', $out, '--server', $url]);
        my $job = running($url);
        ok $job, 'the job runs';
        kill $signal, $process->{pid};
        my ($code, undef, $stderr) = finish($process);
        is $code, $wanted, "SIG$signal ends it with $wanted";
        my $after = decode_json($http->get("$url/v1/jobs/$job->{jobID}")->{content});
        if ($signal eq 'INT') {
            like $stderr, qr/^voronoid: stopping; the best result so far is written/, 'it says so';
            ok $after->{status} eq 'successful' && unlink($out), 'the job is stopped, its best cloud is fetched';
            next;
        }
        is $stderr, "voronoid: $in: cancelled\n", 'it says so';
        is $after->{status}, 'dismissed', 'the job is dismissed';
        ok !-e $out, 'nothing is written';
    }
};

subtest 'somebody else' => sub {
    my $process = start(['resample', $in, @long, '-fo', $out, '--server', $url]);
    $http->delete("$url/v1/jobs/" . running($url)->{jobID});
    my ($code, undef, $stderr) = finish($process);
    is $code, 4, 'dismissed by somebody else is cancelled';
    is $stderr, "voronoid: $in: the job was dismissed\n", 'it says so';
    $process = start(['resample', $in, @long, '--json', '-fo', $out, '--server', $url]);
    $http->post("$url/v1/jobs/" . running($url)->{jobID} . '/stop');
    ($code, my $stdout) = finish($process);
    is $code, 0, 'stopped by somebody else is a result';
    is decode_json((split /\n/, $stdout)[-1])->{stopped}, 'stopped', 'and the report says so';
    unlink $out;
};

subtest 'a stream that breaks off' => sub {
    my $cutter = cutter($daemon->{address}, 2, 2500);
    my @some = ('-n', 4000, '--iterations', 60);
    run(['resample', $in, @some, '-q', '-fo', "$folder/some.ply"]);
    my ($code, $stdout, $stderr) = run(['resample', $in, @some, '--json', '-fo', $out, '--server', $cutter->{url}]);
    kill 'TERM', $cutter->{pid};
    waitpid $cutter->{pid}, 0;
    Cli::forget($cutter->{pid});
    my ($first, @again) = split /\n/, slurp($cutter->{log});
    is "$code$stderr", '0', 'all is well';
    is $first, 'none', 'the first stream begins at the beginning';
    cmp_ok scalar @again, '>=', 1, 'at least one was taken up again';
    like $_, qr/^\d+\.\d+$/, "where it ended: $_" for @again;
    ok slurp($out) eq slurp("$folder/some.ply"), 'the bytes are those of a run here';
    my @records = grep { exists $_->{iteration} } map { decode_json($_) } split /\n/, $stdout;
    my @steps = map { 1e6 * $_->{iteration} + $_->{polish} } @records;
    pop @steps if @steps > 1 && $steps[-1] == $steps[-2]; # what is handed over, told of the last step once more
    is scalar(grep { $steps[$_] <= $steps[$_ - 1] } 1 .. $#steps), 0, 'no record comes twice or late';
    unlink $out, "$folder/some.ply";
};

subtest 'a daemon that is busy' => sub {
    my $small = daemon("$folder/small", '127.0.0.1:0', '--threads', 1, '--jobs', 1, '--queue', 1);
    my @others = map { start(['resample', $in, @long, '-q', '-fo', "$folder/o$_.ply", '--server', $small->{url}]) } 1;
    running($small->{url});
    push @others, start(['resample', $in, @long, '-q', '-fo', "$folder/o2.ply", '--server', $small->{url}]);
    await { @{ jobs($small->{url}) } == 2 };
    my ($code, $stdout, $stderr) = run(['resample', $in, @request, '-fo', $out, '--server', $small->{url}]);
    is "$code|$stdout", '5|', 'is not waited for';
    like $stderr, qr/\Avoronoid: \Q$in\E: The queue is full[^\n]*\n\z/, 'one line says so';
    kill 'INT', $_->{pid} for @others;
    is((finish($_))[0], 130, 'those who wait can leave') for @others;
    is((stop($small))[0], 0, 'the daemon ends well');
};

subtest 'a daemon that dies and comes back' => sub {
    my $mortal = daemon("$folder/mortal", '127.0.0.1:0', '--threads', 2);
    my $process = start(['resample', $in, '-n', 2000, '--iterations', 150, '--json', '-fo', $out, '--server', $mortal->{url}]);
    running($mortal->{url});
    stop($mortal, 'KILL');
    $mortal = daemon("$folder/mortal", $mortal->{address}, '--threads', 2);
    my ($code, $stdout, $stderr) = finish($process);
    is "$code$stderr", '0', 'does not lose the job';
    run(['resample', $in, '-n', 2000, '--iterations', 150, '-q', '-fo', "$folder/alone.ply"]);
    ok slurp($out) eq slurp("$folder/alone.ply"), 'the bytes are those of a run here';
    unlink $out;
    $process = start(['resample', $in, @long, '-fo', $out, '--server', $mortal->{url}]);
    my $job = running($mortal->{url});
    stop($mortal, 'KILL');
    ($code, undef, $stderr) = finish($process);
    is $code, 5, 'one that does not come back is unreachable';
    like $stderr, qr{\Avoronoid: \Q$mortal->{url}\E/v1/jobs/\Q$job->{jobID}\E: [^\n]+\n\z}, 'one line names the job';
    ok !-e $out, 'nothing is written';
};

subtest 'a name' => sub {
    my ($code) = run(['resample', $in, @request, '-fo', $out, '-q', '--name', 'five & six', '--server', $url]);
    is $code, 0, 'all is well';
    is jobs($url)->[0]{voronoid}{name}, 'five & six', 'the daemon knows the job by it';
    ($code, undef, my $stderr) = run(['resample', $in, @request, '-fo', $out, '-q', '--name', 'x' x 201, '--server', $url]);
    is $code, 2, 'one that is too long is refused';
    like $stderr, qr/name is "x+\.\.\.", want 1 to 200 characters/, 'with what one is';
    ($code, undef, $stderr) = run(['resample', $in, @request, '-fo', $out, '--name', 'a']);
    is "$code $stderr", "2 voronoid: resample: --name names the job on a daemon: give --server too\n", 'here there is none';
};

is((stop($daemon))[0], 0, 'the daemon ends well');
done_testing;
