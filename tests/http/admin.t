#!/usr/bin/perl
# The second listener: what it answers, that it answers while the first one is overrun, and what its numbers are like.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use IO::Socket::INET;
use Test::More;
use Vt;

for my $case (
    [['--admin-listen', '0.0.0.0:0'], qr/--admin-listen 0\.0\.0\.0:0 is open to other machines: .*--admin-anywhere/],
    [['--admin-listen', '127.0.0.1'], qr/--admin-listen is "127\.0\.0\.1", want HOST:PORT with a port from 0 to 65535/],
    [['--admin-listen', 'unix:run'], qr{--admin-listen is "unix:run", want unix:/PATH}],
) {
    my ($arguments, $message) = @$case;
    my ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', tempdir(CLEANUP => 1), @$arguments);
    is $status, 2, "@$arguments: exit status 2";
    like $text, $message, "@$arguments: named, with what is wanted";
}

my $daemon = Vt->start('admin-listen' => '127.0.0.1:0', connections => 8);
my $admin = $daemon->{admin};
ok $admin, 'the log names its address';

sub ask {
    my ($method, $path, %headers) = @_;
    return HTTP::Tiny->new(timeout => $Vt::PATIENCE)->request($method, "http://$admin$path", { headers => \%headers });
}
is ask('GET', '/livez')->{status}, 200, '/livez';
is ask('GET', '/readyz')->{status}, 200, '/readyz';
is ask('HEAD', '/metrics')->{status}, 200, 'HEAD of /metrics';
is_problem(ask('GET', $_), 404, 'no-such-resource', "$_ is not there") for qw(/ /v1/jobs /version /openapi.yaml);
for my $method (qw(POST DELETE PUT)) {
    my $answer = ask($method, '/metrics');
    is_problem($answer, 405, 'method-not-allowed', "$method is not taken");
    is $answer->{headers}{allow}, 'GET, HEAD', 'and what is, is said';
}
# HTTP::Tiny sets Host itself.
my $foreign = IO::Socket::INET->new(PeerAddr => $admin) // die "connect: $!";
print $foreign "GET /metrics HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n";
like Vt::read_all($foreign), qr{\AHTTP/1\.1 403 .*Host is evil\.example, want localhost}s, 'a page of elsewhere may not read it';

# Some of each: a result, a refusal, a path of nothing.
my $id = $daemon->submit('points=200&iterations=2', sphere_ply(1000));
$daemon->finish($id);
my $stream = $daemon->events("/v1/jobs/$id/events");
my $events = 0;
while (my $event = $stream->next_event) {
    ($events) = $event->{id} =~ /\.(\d+)$/;    # the number of the last
}
$daemon->post('/v1/resample?points=5', 'no cloud');
$daemon->get('/a/path/that/is/not');
my @silent = map { $daemon->connect } 1 .. 100;
is ask('GET', '/livez')->{status}, 200, 'it answers while the first one has more connections than it takes';
my $answer = ask('GET', '/metrics');
is $answer->{status}, 200, 'with its numbers';
my $kept = `sqlite3 $daemon->{dir}/data/jobs.sqlite 'SELECT sum(length(data)) FROM small_file'` + 0;
is $answer->{headers}{'content-type'}, 'text/plain; version=0.0.4; charset=utf-8', 'in the format that Prometheus reads';
my $client = $ENV{VORONOID} // 'build/release/voronoid';
is system("VORONOID_ADMIN_LISTEN=$admin VORONOID_LISTEN=$daemon->{address} $client health >$daemon->{dir}/health"), 0,
    'a health check by VORONOID_ADMIN_LISTEN asks it';
@silent = ();

# The format's grammar, and what promtool's lint asks for.
my (%type, %help, %value, @faults, $of);
for my $line (split /\n/, $answer->{content}) {
    if ($line =~ /^# (HELP|TYPE) ([a-z_]+) (\S.*)$/) {
        my $table = $1 eq 'HELP' ? \%help : \%type;
        push @faults, "$1 $2 twice" if defined $table->{$2};
        $table->{$2} = $3;
        $of = $2;
    } elsif ($line =~ /^([a-z_]+)(\{(?:[a-z_]+="(?:[^"\\]|\\.)*",?)*\})? (\S+)$/) {
        my ($name, $labels, $number) = ($1, $2 // '', $3);
        my $base = ($type{$of} // '') eq 'histogram' ? $name =~ s/_(?:bucket|sum|count)$//r : $name;
        push @faults, "$name is not of $of" if $base ne $of;
        push @faults, "$name is $number" unless $number =~ /^-?[\d.]+(?:e[-+]\d+)?$/;
        push @faults, "$name$labels twice" if defined $value{"$name$labels"};
        push @faults, "$name holds an identifier: $labels" if $labels =~ /[0-9a-f]{8}-[0-9a-f]{4}/;
        $value{"$name$labels"} = $number;
    } else {
        push @faults, "no line: $line";
    }
}
for my $name (sort keys %type) {
    push @faults, "$name has no HELP" unless $help{$name};
    push @faults, "$name is no $type{$name}" unless ($name =~ /_total$/) == ($type{$name} eq 'counter');
    push @faults, "$name is not ours" unless $name =~ /^(?:voronoid|process)_/;
    push @faults, "$name has another unit" if $name =~ /_(?:ms|milliseconds|minutes|kb|mb|percent)\b/;
}
for my $bucket (grep { /_bucket\{.*le="\+Inf"/ } keys %value) {
    my $count = $bucket =~ s/_bucket/_count/r =~ s/,?le="\+Inf"//r =~ s/\{\}//r;
    push @faults, "$bucket is not $count" unless $value{$bucket} == ($value{$count} // -1);
}
is join("\n", @faults), '', 'every line is sound';
cmp_ok scalar(keys %type), '>=', 35, 'there are many';
my ($version) = json($daemon->get('/version'))->{version};
my ($build) = grep {/build_info/} keys %value;
like $build, qr/\Avoronoid_build_info\{version="\Q$version\E",engine="[0-9a-f]{12}",simd="(?:x86-64-v[34]|baseline)"\}\z/,
    'the build is told by version, engine and vectors';
is $value{'voronoid_http_requests_total{route="none",method="GET",code="404"}'}, 1, 'paths of strangers are one';
is $value{'voronoid_http_requests_total{route="/v1/resample",method="POST",code="201"}'}, 1, 'a submit is counted by its route';
is $value{'voronoid_rejected_total{reason="unsupported-format"}'}, 1, 'and a refusal by its reason';
is $value{'voronoid_decode_errors_total{format="none",reason="unsupported-format"}'}, 1, 'as is what could not be decoded';
is $value{'voronoid_jobs_submitted_total{process="resample"}'}, 1, 'a job is counted when it is accepted';
is $value{'voronoid_jobs_finished_total{process="resample",status="successful"}'}, 1, 'and when it is over';
is $value{"voronoid_job_duration_seconds_count{process=\"resample\",stage=\"$_\"}"}, 1, "its stage $_ has a time"
    for qw(all read index init iterate write);
is $value{'voronoid_job_points_sum{direction="in"}'}, 1000, 'with its points';
is $value{'voronoid_job_points_sum{direction="out"}'}, 200, 'in and out';
is $value{'voronoid_memory_reserved_bytes'}, 0, 'no memory stays reserved';
is $value{'voronoid_queue_jobs{state="waiting"}'}, 0, 'nothing waits';
is $value{'voronoid_uploads_active'}, 0, 'no upload is under way';
is $value{'voronoid_upload_bytes_total'}, length(sphere_ply(1000)) + length('no cloud'), 'those that were are counted by their bytes';
is $value{'voronoid_blob_bytes{store="dir"}'}, $kept, 'and what is kept of them and of the result';
is $value{'voronoid_worker_restarts_total'}, 0, 'no worker had to be replaced';
is $value{'voronoid_sse_events_total'} + $value{'voronoid_sse_dropped_total'}, $events, 'an event was sent, or told as dropped';
cmp_ok $value{'voronoid_connections'}, '>=', 8, 'open connections are counted';
cmp_ok $value{'process_resident_memory_bytes'}, '>', 1 << 20, 'and memory';
cmp_ok abs($value{'process_start_time_seconds'} - $^T), '<', 120, 'the process began when it did';
is $daemon->stop, 0, 'both listeners end';
done_testing();
