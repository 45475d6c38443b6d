#!/usr/bin/perl
# Several daemons on one PostgreSQL and one S3 bucket, real ones: any of them answers anything, and those that are killed or stopped
# take no job with them. The first one polls; the others do so through pgbouncer, and are told of changes by a direct connection.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use HTTP::Tiny;
use lib "$FindBin::Bin/../support", $FindBin::Bin;
use Scale;
use Test::More;
use Vt;

ok start_postgres(), 'PostgreSQL serves' or BAIL_OUT Vt::slurp("$Scale::dir/postgres.out");
ok start_swift(), 'Swift serves' or BAIL_OUT Vt::slurp("$Scale::dir/proxy.out");
ask('postgres', 'CREATE DATABASE daemons');
my %place = (store => "postgresql://voronoid\@127.0.0.1:$Scale::postgres/daemons", blobs => "s3:http://127.0.0.1:$Scale::swift{proxy}/bucket");
my %told = (%place, store => $place{store} =~ s/voronoid\@.*:\K$Scale::postgres/$Scale::pooler/r, 'store-listen' => $place{store} =~ s/voronoid\K/:secret-word/r);
my $cloud = sphere_ply(3000);
my $alone = Vt->start(jobs => 1);
my $wanted = $alone->post('/v1/resample?points=500', $cloud)->{content};

# What a daemon has in its folder moves to both. Status and what it says; it gets the places by the environment.
my @moved = map { $alone->submit('points=500', $cloud) } 1 .. 2;
$alone->finish($_) for @moved;
my $waits = $alone->submit('points=5000&iterations=10000&delta=0', $cloud);
ok wait_until(sub { $alone->status($waits) eq 'running' }), 'a daemon alone has jobs';
sub migrate {
    local @ENV{qw(VORONOID_STORE VORONOID_BLOBS)} = @place{qw(store blobs)};
    my $said = `@{[$ENV{VORONOID} // 'build/release/voronoid']} migrate $alone->{dir}/data 2>&1`;
    return ($? >> 8) . " $said";
}
like migrate(), qr/\A75 voronoid: migrate: /, 'they are not moved while it runs';
$alone->stop('KILL');
like migrate(), qr/\A0 4 jobs \(0 were there already\) and (\d+) files \(0\), /, 'but after that';
like migrate(), qr/\A0 4 jobs \(4 were there already\) and (\d+) files \(\1\), /, 'and once';
my @daemons = map { Vt->start(%$_, jobs => 1) } \%place, \%told, \%told;
my ($one, $other, $third) = @daemons;
my ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$Scale::dir/alone", '--store', $place{store});
is $status, 75, 'a daemon that has its files in a folder cannot join them';
like migrate(), qr/\A75 voronoid: migrate: another daemon is already using the job store/, 'nor is anything moved to them';
ok wait_until(sub { $third->status($waits) eq 'running' }), 'what ran when it was moved runs again';
is $other->request('DELETE', "/v1/jobs/$waits")->{status}, 200, 'and can be dismissed';
is scalar(grep { $other->get("/v1/jobs/$_/results/cloud")->{content} eq $wanted && $one->finish($_)->{status} eq 'successful' } @moved), 2, 'results are there';

# What one accepts, another one shows.
my $long = $one->submit('points=5000&iterations=10000&delta=0', sphere_ply(20000)); # a minute and more, if nobody ends it
ok wait_until(sub { $_->status($long) eq 'running' }), 'all see that a job runs' for @daemons;
my @elsewhere = grep { $_->log_text !~ /"msg":"job started","job":"$long"/ } @daemons;
my $stream = $elsewhere[0]->events("/v1/jobs/$long/events");
my @seen;
while (@seen < 8 && (my $event = $stream->next_event)) { push @seen, $event->{id} if $event->{id} }
is @seen, 8, 'its events come from another one';
is_deeply \@seen, [sort { ($a =~ s/.*\.//r) <=> ($b =~ s/.*\.//r) } @seen], 'in order';
my ($looks, $shown) = $elsewhere[0]->events("/v1/jobs/$long/events?preview=100");
1 while ($shown = $looks->next_event) && $shown->{event} ne 'preview';
is scalar(grep { $_->get("/v1/jobs/$long/preview?points=100")->{content} =~ /^element vertex 100$/m } @daemons), 3, 'where its points are is seen at all';
my ($runner) = grep { $_->log_text =~ /"msg":"job started","job":"$long"/ } @daemons;
my ($ahead, $next) = ($runner->events("/v1/jobs/$long/events"));
1 while $next = $ahead->next_event and ($next->{id} // '1.0') !~ /\.\d\d/;
my ($last) = $next->{id} =~ /\.(\d+)$/;
$next = $elsewhere[1]->events("/v1/jobs/$long/events", headers => { 'Last-Event-ID' => $next->{id} })->next_event;
cmp_ok $next->{id} =~ s/.*\.//r, '>', $last, 'who comes from the daemon that runs it, and is ahead, sees none twice';
cmp_ok json($elsewhere[1]->get("/v1/jobs/$long"))->{progress}, '>', 0, 'and its progress';
is $elsewhere[1]->request('DELETE', "/v1/jobs/$long")->{status}, 200, 'another one dismisses it';
ok wait_until(sub { $_->status($long) eq 'dismissed' }), 'all see that' for @daemons;
is $runner->finish($runner->submit('points=100', $cloud))->{status}, 'successful', 'and the one that ran it goes on';
my $end;
while (my $event = $stream->next_event) { $end = $event }
like $end->{data}, qr/dismissed/, 'the stream ends with that';

# Many jobs, by all; results from any.
my @ids = map { $daemons[$_ % 3]->submit('points=500', $cloud) } 1 .. 30;
is scalar(grep { $daemons[rand 3]->finish($_)->{status} eq 'successful' } @ids), @ids, 'jobs end well';
is scalar(grep { $daemons[rand 3]->get("/v1/jobs/$_/results/cloud")->{content} eq $wanted } @ids), @ids, 'with the same bytes, from any';
for my $id (map { $one->submit("points=300&iterations=600&delta=0&polish=0&seed=$_", $cloud) } 1 .. 3) {
    my ($count, $cuts, $bad) = follow($id, 100, @daemons);
    ok $count > 600 && !$bad, "who is cut $cuts times, and goes on at any, sees each of $count events once";
}
my @endless = map { $one->submit('points=5000&iterations=10000&delta=0', sphere_ply(20000)) } @daemons;
ok wait_until(sub { 3 == grep { $other->status($_) eq 'running' } @endless }), 'each runs one at the same time, as it may run no more';
is scalar(grep { $third->request('POST', "/v1/jobs/$_/stop")->{status} == 202 } @endless), 3, 'any stops them early';
is scalar(grep { $other->finish($_)->{status} eq 'successful' } @endless), 3, 'whoever runs them, and they have results';
is $one->post('/v1/resample?points=500', $cloud)->{content}, $wanted, 'a caller who waits gets his result, whoever runs it' for 1 .. 3;

# One is killed while it runs a job: its lease ends, and another one runs it again.
$long = $one->submit('points=2000&seed=3&iterations=1000&delta=0', $cloud);
ok wait_until(sub { $one->status($long) eq 'running' }), 'a job runs';
my $killed;
ok wait_until(sub { ($killed) = grep { $daemons[$_]->log_text =~ /"msg":"job started","job":"$long"/ } 0 .. 2; defined $killed }), 'somewhere';
$daemons[$killed]->stop('KILL');
my @left = @daemons[grep { $_ != $killed } 0 .. 2];
my $report = $left[0]->finish($long);
is $report->{status}, 'successful', 'another one runs it when its daemon is killed';
like ask('daemons', "SELECT attempt FROM job WHERE id = '$long'"), qr/^2$/, 'by its second attempt';

# One is stopped past its lease and goes on: what it then writes counts for nothing.
$long = $left[0]->submit('points=2000&seed=4&iterations=1000&delta=0', $cloud);
my ($frozen) = grep { defined } @{ wait_until(sub { my @f = grep { $_->log_text =~ /"msg":"job started","job":"$long"/ } @left; @f ? \@f : undef }) };
kill 'STOP', $frozen->{pid};
my ($awake) = grep { $_ != $frozen } @left;
is $awake->finish($long)->{status}, 'successful', 'another one runs the job of one that is stopped';
my $result = $awake->get("/v1/jobs/$long/results/cloud")->{content};
kill 'CONT', $frozen->{pid};
$frozen->{http} = HTTP::Tiny->new(timeout => $Vt::PATIENCE); # it closes the connection of before
is $frozen->finish($frozen->submit('points=100', $cloud))->{status}, 'successful', 'which goes on';
ok wait_until(sub { $frozen->get("/v1/jobs/$long/results/cloud")->{content} eq $result }), 'and has the same result';

# Some only answer, some only run jobs.
$_->stop for @left;
Scale::write_file("$Scale::dir/keys", 'root:admin:' . sha256_hex('secret-of-root'));
chmod 0600, "$Scale::dir/keys";
my @keyed = map { Vt->start(%place, role => 'api', 'api-keys' => "$Scale::dir/keys") } 1 .. 2;
my $link = json($keyed[0]->request('POST', "/v1/jobs/$moved[0]/tickets", headers => { Authorization => 'Bearer secret-of-root' }, content => ''))->{href};
($link) = $link =~ m{(/v1/.*)} or diag $link;
is $keyed[1]->get($link)->{content}, $wanted, 'the ticket of one is good at another';
is $keyed[1]->get($link =~ s/.\z//r)->{status}, 401, 'but nothing else is';
$_->stop for @keyed;
my $api = Vt->start(%told, role => 'api', 'admin-listen' => '127.0.0.1:0');
my $id = $api->submit('points=500', $cloud);
is $api->status($id), 'accepted', 'what an api daemon accepts waits';
my $worker = Vt->start(%told, role => 'worker', jobs => 1, 'exit-when-idle' => 2);
is $api->finish($id)->{status}, 'successful', 'until there is a worker';
my $heard = sub { $api->metric('store_hints_total\{direction="received"\}') };
ok wait_until($heard), 'which tells it so';
ok wait_until(sub { ask('postgres', "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE query ~ 'LISTEN|pg_notify' AND pid <> pg_backend_pid()") }), 'none is told any more';
is $api->get("/v1/jobs/$id/results/cloud")->{content}, $wanted, 'the api daemon has its results';
unlike $api->log_text, qr/"msg":"job started"/, 'and ran no job';
is Vt::reap(delete $worker->{pid}), 0, 'a worker that finds no job ends';
$worker = Vt->start(%told, role => 'worker');
is $api->finish($api->submit('points=100', $cloud))->{status}, 'successful', 'jobs end';
my $before = $heard->();
ok wait_until(sub { $api->submit('points=100', $cloud) && $heard->() > $before }), 'and it is told again some time';
is $worker->get('/readyz')->{status}, 200, 'one that waits for jobs is ready';
is $worker->get('/v1/jobs')->{status}, 404, 'and answers nothing else';
Scale::write_file("$Scale::dir/$_.ply", $cloud) for qw(a b c);
my $frames = $api->request('POST', '/v1/processes/resample/frames?points=500', headers => { 'Content-Type' => 'application/x-tar' },
    content => scalar qx(tar -C $Scale::dir -c a.ply b.ply c.ply))->{content};
Scale::write_file("$Scale::dir/frames.tar", $frames);
is join(' ', split ' ', qx(tar -tf $Scale::dir/frames.tar)), 'a.json a.ply b.json b.ply c.json c.ply', 'frames go from result to result elsewhere';
for my $case ([qw(role api)], [qw(role worker)], ['store-listen', $told{'store-listen'}]) {
    ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$Scale::dir/alone", "--$case->[0]", $case->[1]);
    is $status, 2, "a daemon that shares nothing has no $case->[0]";
    like $text, qr/\A[^\n]*$case->[0] is (?:api or worker, but these roles are )?only for daemons that share their jobs[^\n]*\n\z/, 'which it says in a line';
}
unlike $_->log_text, qr/secret-word/, 'no log has a password' for @daemons, $api, $worker;
is ask('daemons', "SELECT count(*) FROM job WHERE status NOT IN ('successful', 'dismissed')"), 0, 'no job is left';
done_testing;
